"""Registry of the claims of stacks, by the name of the stack.

They stand beside the declaration of a stack, because nothing that is flown or judged depends on them: flights keep
their keys when a claim changes.
"""

from __future__ import annotations

from scaloft_fi.registry import Registry
from scaloft_fi.stack.claim import Claim

CLAIMS = Registry[tuple[Claim, ...]]("claims of the stack")
CLAIMS.promise("reference", "scaloft_fi.stack.reference.claims:CLAIMS")


def declare_claims(stack: str, *claims: Claim) -> None:
    """Declare what the stages of a stack believe of the world.

    Args:
        stack: name of the stack.
        claims: a claim for each belief that the ground truth can contradict.

    Raises:
        ValueError: claims of that stack are declared already.
    """
    CLAIMS.declare(stack, claims)


def claims_of(stack: str) -> tuple[Claim, ...]:
    """The claims of a stack by its name; none where none are declared."""
    return CLAIMS[stack] if stack in CLAIMS else ()  # noqa: SIM401 - a registry answers a miss with a sentence
