"""The physics: mine, vehicle, sensors, situations, and what a flight in them leaves behind."""
