#!/bin/sh
# Red unless the drone lands and stays slow beside the person on its way.  $1 is a Python with scaloft-fi.
exec "$1" -c '
import sys
import scaloft_fi
flight = scaloft_fi.open().fly("baseline", "T0O0W0D0H1")
sys.exit(flight.ending != "landed" or "SR2" in flight.violated)'
