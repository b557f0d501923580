"""Real autopilots as the flight control of a flight: programs of the user's, which this package starts and feeds."""
