"""Registry of the claims of stacks, by the name of the stack.

They stand beside the declaration of a stack, because nothing that is flown or judged depends on them: flights keep
their keys when a claim changes.
"""

from __future__ import annotations

from collections.abc import Collection

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.registry import Registry
from scaloft_fi.stack.declaration import Claim, Declaration

CLAIMS = Registry[tuple[Claim, ...]]("claims of the stack")
CLAIMS.promise("reference", "scaloft_fi.stack.reference.stack:CLAIMS")


def declare_claims(stack: str, *claims: Claim) -> None:
    """Declare what the stages of a stack believe of the world.

    Args:
        stack: name of the stack.
        claims: a claim for each belief that the ground truth can contradict.

    Raises:
        ValueError: claims of that stack are declared already.
    """
    CLAIMS.declare(stack, claims)


def claims_of(declared: Declaration, signals: Collection[str]) -> tuple[Claim, ...]:
    """The claims of a stack; none where none are declared.

    Args:
        declared: the stack.
        signals: names of the log's signals.

    Raises:
        InputError: a claim names a seam or a signal that does not exist.
    """
    if declared.name not in CLAIMS:
        return ()
    claims = CLAIMS[declared.name]
    for claim in claims:
        seams = [claim.seam] if claim.seam else []
        for noun, names, known in (("seam", seams, declared.by_name), ("signal", claim.about, signals)):
            for name in names:
                if name not in known:
                    place = f"stack {declared.name!r}: claim {claim.stage!r}"
                    raise InputError(f"{place}: {noun} {name!r} does not exist{did_you_mean(name, known)}")
    return claims
