"""A stack under test, as the framework sees it: its declaration, its contract, and the messages of sensors and rotors.

A stack states its seams and beliefs in a `Declaration`; the flight loop calls it as a `Stack`; it sends each sample of
a seam over a `Wire`; `check_stack` (`scaloft_fi.api`) checks all that.  `reference` is our drone, a stack like any
other.  Nothing here imports the rest of the package, and no stack knows that mutants exist.
"""

from scaloft_fi.stack.declaration import Belief, Declaration, Mark, PlainStack, PlainWire, Seam, Stack, Task, Wire

__all__ = ["Belief", "Declaration", "Mark", "PlainStack", "PlainWire", "Seam", "Stack", "Task", "Wire"]
