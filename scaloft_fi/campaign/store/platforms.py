"""The platform of a store's flights, and the platforms on which a sample of them had the same digests."""

from __future__ import annotations

import json
from hashlib import sha256

from scaloft_fi.campaign.store.fingerprint import differences, fingerprint
from scaloft_fi.campaign.store.store import NOTE, Store


def unproved(store: Store, ours: dict[str, str]) -> list[str]:
    """The differences of the platform `ours` from the store's, each as `numpy 2.4.6 here, 1.26.4 there`.

    Empty if no sample has to be flown: the platforms are equal, a sample on `ours` had the same digests, or the store
    has no platform yet.
    """
    theirs = store.meta()
    return differences(ours, theirs) if theirs and _agreement(ours, theirs) not in store.notes() else []


def warning_for(store: Store) -> str:
    """The warning about the store's platform for verbs that only read; empty without one."""
    changed = unproved(store, fingerprint())
    if not changed:
        return ""
    return f"flown on another platform, and no sample was flown again on this one: {', '.join(changed)}"


def agree(store: Store, ours: dict[str, str]) -> None:
    """Record that a sample on the platform `ours` had the digests of the store.

    Raises:
        InputError: the store cannot be written.
    """
    store.set_notes({_agreement(ours, store.meta()): json.dumps(ours, sort_keys=True)})


def outgrow(store: Store, ours: dict[str, str]) -> None:
    """Make every flight of the store stale, as a flight of the earlier platform; the store's platform becomes `ours`.

    The flights stay in the store under other keys, so nothing is lost.

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
    """The name of the note that a sample had the same digests on both platforms."""
    return f"sample agrees: {_digest(theirs)[:16]} {_digest(ours)[:16]}"


def _digest(platform: dict[str, str]) -> str:
    return sha256(json.dumps(platform, sort_keys=True).encode()).hexdigest()
