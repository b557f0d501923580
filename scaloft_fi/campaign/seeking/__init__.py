"""The search for situations that show a fault: proposals, flights, confirmation, finds."""
