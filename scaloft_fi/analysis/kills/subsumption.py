"""Dynamic subsumption: which mutants die wherever another does, and so say nothing that the other does not.

A mutant subsumes another when something kills it and whatever kills it kills the other too: kills(a) is not empty and
within kills(b).  Mutants with equal kill sets are one node; the nodes that no other subsumes are the minimal ones
(Ammann, Delamaro and Offutt, "Establishing theoretical minimal sets of mutants", ICST 2014; Kurtz et al., "Mutant
subsumption graphs", Mutation 2014).  It holds of the situations flown, not of all there could be.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from scaloft_fi.analysis.kills.kill_matrix import KillMatrix
from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.hazop.name import cell_of


@dataclass(frozen=True)
class Node:
    """Mutants that the same situations kill.

    Attributes:
        mutants: ids, in the order given.
        kills: what kills them.
    """

    mutants: tuple[str, ...]
    kills: frozenset[str]

    @property
    def name(self) -> str:
        """The first mutant's id."""
        return self.mutants[0]


@dataclass(frozen=True)
class Subsumption:
    """The subsumption graph.

    Attributes:
        nodes: in the order of their first mutants.
        edges: (subsuming, subsumed) places in `nodes`, without those that follow from others.
    """

    nodes: tuple[Node, ...]
    edges: tuple[tuple[int, int], ...]

    @cached_property
    def minimal(self) -> tuple[Node, ...]:
        """The nodes that no other subsumes."""
        subsumed = {below for _, below in self.edges}
        return tuple(node for place, node in enumerate(self.nodes) if place not in subsumed)

    @property
    def killed(self) -> int:
        """Mutants in the graph: those that something kills."""
        return sum(len(node.mutants) for node in self.nodes)

    def layers(self) -> tuple[tuple[int, ...], ...]:
        """The nodes by the longest way down to them; the first layer is the minimal ones."""
        depth: dict[int, int] = {}
        # a node's kill set is larger than those of the nodes above it
        for place in sorted(range(len(self.nodes)), key=lambda n: (len(self.nodes[n].kills), n)):
            depth[place] = max((depth[above] + 1 for above, below in self.edges if below == place), default=0)
        return tuple(
            tuple(place for place in range(len(self.nodes)) if depth[place] == layer)
            for layer in range(max(depth.values(), default=-1) + 1)
        )

    def dominator_score(self, chosen: Collection[str]) -> Ratio:
        """Minimal nodes that the chosen columns kill, of all minimal nodes.

        Redundant mutants do not count in it; over all columns it is 1 by construction.  Source: Kurtz et al.,
        "Analyzing the validity of selective mutation with dominator mutants", FSE 2016.
        """
        columns = set(chosen)
        return Ratio(sum(bool(node.kills & columns) for node in self.minimal), len(self.minimal))

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; `layer` and `minimal` of each node beside its mutants and what kills them."""
        layer = {place: number for number, members in enumerate(self.layers()) for place in members}
        return {
            "nodes": [
                {
                    "mutants": list(node.mutants),
                    "kills": sorted(node.kills),
                    "layer": layer[place],
                    "minimal": layer[place] == 0,
                }
                for place, node in enumerate(self.nodes)
            ],
            "edges": [list(edge) for edge in self.edges],
            "killed": self.killed,
            "distinct": len(self.nodes),
            "minimal": len(self.minimal),
        }


def subsumption(kills: Mapping[str, Collection[str]]) -> Subsumption:
    """The subsumption graph of kill sets, by mutant; mutants that nothing kills are not in it."""
    import networkx as nx

    classes: dict[frozenset[str], list[str]] = {}
    for mutant, keys in kills.items():
        if keys:
            classes.setdefault(frozenset(keys), []).append(mutant)
    nodes = tuple(Node(tuple(mutants), keys) for keys, mutants in classes.items())
    full = nx.DiGraph()
    full.add_nodes_from(range(len(nodes)))
    full.add_edges_from(
        (above, below)
        for above, upper in enumerate(nodes)
        for below, lower in enumerate(nodes)
        if upper.kills < lower.kills
    )
    return Subsumption(nodes, tuple(sorted(nx.transitive_reduction(full).edges)))


def kills_by_requirement(matrix: KillMatrix) -> dict[str, frozenset[str]]:
    """Per mutant with a kill what kills it as `SITUATION REQUIREMENT`, each requirement for itself.

    A flight that ends at a contact cannot show what it would have violated later.
    """
    return {
        row.id: frozenset(f"{entry.situation} {name}" for entry in row.entries for name in entry.kills)
        for row in matrix.mutants
        if row.kills
    }


@dataclass(frozen=True)
class Redundancy:
    """How many killed mutants of a cell say the same.

    Attributes:
        cell: name.
        killed: mutants of the cell that something kills: magnitudes and phases.
        duplicates: groups of two or more of them with the same kill set.
    """

    cell: str
    killed: int
    duplicates: tuple[tuple[str, ...], ...]

    @property
    def redundant(self) -> Ratio:
        """Mutants that could be left out without losing a kill set of the cell, of those killed."""
        return Ratio(sum(len(group) - 1 for group in self.duplicates), self.killed)


def redundancies(graph: Subsumption) -> tuple[Redundancy, ...]:
    """The redundancy within each cell that has two or more killed mutants, in the order of the nodes."""
    cells: dict[str, list[list[str]]] = {}
    for node in graph.nodes:
        groups: dict[str, list[str]] = {}
        for mutant in node.mutants:
            groups.setdefault(cell_of(mutant), []).append(mutant)
        for cell, members in groups.items():
            cells.setdefault(cell, []).append(members)
    redundant = []
    for cell, groups_of_cell in cells.items():
        killed = sum(map(len, groups_of_cell))
        if killed > 1:
            redundant.append(Redundancy(cell, killed, tuple(tuple(g) for g in groups_of_cell if len(g) > 1)))
    return tuple(redundant)
