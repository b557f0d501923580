"""The platform on which the flights of a store were flown, and others on which a sample came out the same."""

from __future__ import annotations

import json
from hashlib import sha256

from scaloft_fi.campaign.store.fingerprint import differences, fingerprint
from scaloft_fi.campaign.store.store import NOTE, Store


def unproved(store: Store, ours: dict[str, str]) -> list[str]:
    """How the platform `ours` differs from the store's, each as `numpy 2.4.6 here, 1.26.4 there`.

    Nothing when no sample has to be flown: the platforms are equal, a sample flown on `ours` agreed, or the store has
    no platform yet.
    """
    theirs = store.meta()
    return differences(ours, theirs) if theirs and _agreement(ours, theirs) not in store.notes() else []


def warning_for(store: Store) -> str:
    """What a person who only reads the store must know of its platform; empty when there is nothing."""
    changed = unproved(store, fingerprint())
    if not changed:
        return ""
    return f"flown on another platform, and no sample was flown again on this one: {', '.join(changed)}"


def agree(store: Store, ours: dict[str, str]) -> None:
    """Keep that a sample flown again on the platform `ours` had the digests of the store.

    Raises:
        InputError: the store cannot be written.
    """
    store.set_notes({_agreement(ours, store.meta()): json.dumps(ours, sort_keys=True)})


def outgrow(store: Store, ours: dict[str, str]) -> None:
    """Set every flight of the store apart as one of the earlier platform; from now on the platform is `ours`.

    The flights keep their place in the store under other keys, so that they are stale and nothing is lost.

    Raises:
        InputError: the store cannot be written.
    """
    with store.transaction() as connection:
        theirs = store.meta()
        if theirs == ours:  # another process was faster
            return
        reason = ", ".join(differences(ours, theirs))

        def apart(key: str) -> str:
            return sha256(f"{_digest(theirs)}\n{key}".encode()).hexdigest()

        connection.create_function("apart", 1, apart, deterministic=True)
        fresh = [(number, origin) for number, origin in store.origins().items() if not origin.platform]
        numbers = ", ".join(str(number) for number, _ in fresh)
        for table in ("outcomes", "plan"):
            # a flight that was set apart before for the same reason has the same bits: one is enough
            connection.execute(
                f"UPDATE OR REPLACE {table} SET key = apart(key) WHERE origin IS NULL OR origin IN ({numbers})"
            )
        for number, origin in fresh:
            parts = json.dumps(origin._replace(platform=reason)._asdict())
            known = connection.execute("SELECT id FROM origins WHERE parts = ?", (parts,)).fetchone()
            if known is None:
                connection.execute("UPDATE origins SET parts = ? WHERE id = ?", (parts, number))
                continue
            for table in ("outcomes", "plan"):
                connection.execute(f"UPDATE {table} SET origin = ? WHERE origin = ?", (*known, number))
            connection.execute("DELETE FROM origins WHERE id = ?", (number,))
        connection.execute("DELETE FROM meta WHERE name NOT LIKE ?", (f"{NOTE}%",))
        connection.executemany("INSERT INTO meta VALUES (?, ?)", ours.items())


def _agreement(ours: dict[str, str], theirs: dict[str, str]) -> str:
    """The name of the note that a sample had on both platforms the same digests."""
    return f"sample agrees: {_digest(theirs)[:16]} {_digest(ours)[:16]}"


def _digest(platform: dict[str, str]) -> str:
    return sha256(json.dumps(platform, sort_keys=True).encode()).hexdigest()
