"""The two rates of a flight: physics steps, and ticks of the stack's companion, of most sensors and of the log."""

STEP_HZ, TICK_HZ = 240.0, 20.0
STEP_S, TICK_S = 1.0 / STEP_HZ, 1.0 / TICK_HZ
STEPS_PER_TICK = 12
