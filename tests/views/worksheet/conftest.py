"""The operators of the reference stack, which the matrix of the repository names."""

import scaloft_fi.mutants.reference  # noqa: F401 - declares the operators
