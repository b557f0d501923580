"""What a stack under test is to the framework: its declaration, its contract, and the messages of sensors and rotors.

`Declaration` is what a stack declares, `Stack` is how the flight loop calls it, `Wire` is how it sends each sample of a
seam, `check_stack` (`scaloft_fi.api`) holds it to all that.  `reference` is our drone, a stack like any other.  Nothing
here imports the rest of the package, and no stack knows that mutants exist.
"""

from scaloft_fi.stack.belief import Belief, Mark
from scaloft_fi.stack.contract import PlainStack, Stack, Task
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.stack.seam import PlainWire, Seam, Wire

__all__ = ["Belief", "Declaration", "Mark", "PlainStack", "PlainWire", "Seam", "Stack", "Task", "Wire"]
