"""Stages and simulators in other processes: what starts them, what carries samples to them, and what they record."""
