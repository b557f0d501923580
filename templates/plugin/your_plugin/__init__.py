"""An operator, a sensor, a signal and a stack for scaloft-fi."""
