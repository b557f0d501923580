"""The glossary: every term of the screens, tables, files and the report, with its meaning."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

GLOSSARY = """
--choose: How situations were chosen from the grid, such as `all`, `random:20` or `2-way`.
accepted: A survivor with a disposition in `hazop/dispositions.yaml` that covers it.
accepted in: The situations that a disposition names.
action status | action_status: How far the action is; for the team.
acts at | acts at [s]: When the fault altered its first sample [s from take-off]: median over the flights (earliest to
  latest).
again: Magnitudes that survive although a milder one is killed or seen: the response is not monotone.
alias: A second name of a situation, such as the paper's number.
alike: Of the flights that confirm a break, those that break in the same way, flights with the same signature.
alpha: The chance that a mutant which does nothing is called detected: 0.01 unless the campaign spends less.
altered | samples altered: Number of samples that the fault changed in a flight.
answer: The sentence that answers the question beside it.
archive: A campaign's record as one folder or ZIP file, with its study; every verb that reads opens it as a campaign.
arguments: The settings of the operator that makes the fault.
asks: The versions that scaloft-fi asks for.
at most %: Share of the killed mutants whose kill order is this or less.
axis | axes: One thing in which situations differ, such as darkness; it has two or more values, or is a range of a
  number.
baseline | unmutated drone | clean drone: The drone without any fault.  In the table of finds: flights of it that hold
  the requirement by more than their spread, of all.
baseline pool | pool: All flights of the unmutated drone in a situation, ten seeds or more: what chance alone does
  there.
baseline_red: Status of a flight that violates a safety requirement, but only as the unmutated drone with the same
  seed does too.
belief: A number that the stack believes, such as its position; it is logged beside the ground truth.
benign: The harmless value of an axis; its id is 0.
bin: A part of a range of an axis; all bins of a range have the same probability.
break | breaks: A situation in which the unmutated drone itself violates a safety requirement, found by `seek
  baseline`.
budget: Wall time, or number of flights, after which a run or a search begins nothing more.
by: The requirements that kill, each with the situations where it kills / where it tests the mutant.
campaign: The planned flights and their outcomes in one folder; score, coverage and report are made from it.
carried: Number of samples that passed the patched seams in a flight.
catalogue: The list of all mutants that the matrix gives, in `mutants/catalogue.jsonl`.
category: The part of the operational design domain that an axis belongs to, such as `environment, light level`.
causes | possible causes: What could bring a deviation about.
cell | cells | deviation id: One entry of the deviation matrix: a guideword asked of a parameter.
claim: Something that somebody might conclude from the campaign; or, of a stack, what one of its stages believes of
  the world.
clearance: Distance from the drone's hull to the nearest thing it could touch [m], measured up to 1 m; below 0 it
  touches.
combinations: Values of t axes taken together; t-way coverage counts how many were flown.
condition: The shortest description of the situations where a mutant is killed, such as `human & light`.
control | controls: A crude fault that the tests must show; if it survives, the test bench is broken.  It is in no
  ratio.
controls and PLACEBO: The mutants that test the test bench instead of the drone.
coverage | situation coverage: Which part of all situations, and of all combinations of their values, was flown.
covered: Combinations that were flown, of all that the grid has.
credible: A cell that can happen: its mutants are flown and counted.
decides bits: Whether this part of the platform can change the bits of a flight.
default | default mutant | default mutants | default_mutant: The one mutant that stands for its cell in the score; `*`
  marks it in the list.
design intent | design_intent: What the parameter should do; every deviation deviates from it.
detected | shown: Verdict: all flights of a mutant together violate a requirement more often than chance explains;
  your tests would have shown the fault.
detected by | mutants detected by it, of those that it put to the test: Mutants that this requirement detects /
  mutants that it puts to the test.
detected so far: On the live screen of `run`: mutants that the score would call detected by the flights that are stored
  now, of those flown so far.
detected/flown: Mutants detected / mutants flown.
detected/tested: Mutants detected / mutants put to the test.
deterministic: A stack whose flight with the same inputs has the same bits each time.
deviation | deviation, or why it is not meaningful: What differs from the design intent when the guideword applies.
digest: A fingerprint of everything that happened in a flight: equal digests mean equal flights, to the bit.
disposition: The decision of a person, with owner, reason and last day, to accept a survivor.
distinct behaviours: Detected mutants, of which those count once whose flights all equal each other's to the bit.
distinct situations: Different situations that were flown; the same one with another seed is no other.
document: A YAML file of a study, by the name of its JSON Schema.
dominator score: Minimal mutants that are killed, of all minimal mutants; redundant mutants do not count in it.
draw | draws | test cases | test case: A situation flown with one seed.
due | due date: When an action is to be done; for the team.
duration_s: How long the flight lasted, in simulated time [s].
edge: Who sends the samples of a seam, and who receives them.
effect | consequence: What the fault does: locally, then to the flight.
ending: How a flight ended: landed, struck or timed out; it is no verdict.
error | errors: A finding of `check` that a verb refuses, or that makes flights mean nothing.
event | events: Something that occurs in a flight, such as passing a waypoint, at which a fault may strike.
exercised: Credible cells whose default mutant was flown, of all credible cells.
expected: The study declares, with a reason, that this mutant alters nothing in this grid.
expired: The last day of a disposition has passed: the ratchet fails.
expires: Last day on which a disposition holds.
false detections | expected_false: How many mutants would be called detected on average, at most, if none had any
  effect: alpha times the mutants tested.  It says nothing of a single mutant that is detected.
fault | faults: A change of the samples at one seam, made by an operator; a mutant is a fault with its magnitude and
  its time.
file: Name of a file with a record.
files: The files of a study that a document is, `*` for any name.
find | finds: A situation that a search found for a survivor and that fresh seeds confirmed.
finding | findings: What the campaign says about a thing; above all, what the unmutated drone itself does wrong.
  Of `check`: what it found in the study, an error or a note.
firm | firm_by_pool: A detected mutant that stays detected when any one seed is left out of its own flights and,
  separately, any one out of the baseline pool.  With one seed of its own it is firm by the pool alone.
first: The earliest violation that counts: its time [s from take-off], and in the long table its place and what was
  struck.
flies it | flies_find: The command that flies the find.
flight | flights: One subject in one situation with one seed, flown from take-off to its end.
flights that violate it: Flights of the unmutated drone that violate the requirement / flown.
flown: What was flown at least once with a flight that counts.
flown at: The magnitudes that were flown, in order.
for: The part of scaloft-fi that needs the package.
formula | formula over the flight: The requirement in signal temporal logic.
free axis: A number around the situations of a grid that a search may change; at its benign value it stands in no key.
gate: A check of the test bench before any score, such as PLACEBO equal to the baseline; when it fails the exit code
  is 4.
grid | the grid: All situations: every combination of the values of the axes.
guideword: A word such as NO, MORE or LATE that asks how a parameter could deviate.
hangs on a seed | hangs_on_a_seed: A detected mutant that is not detected any more when some one seed is left out.
happening: What changes around the drone during a flight: light, wind, dust, a person who walks.
harmless: Samples passed at this magnitude and none was changed, where another magnitude changes some: it survives.
harness: The test bench: simulator, workers, store.  Stopped at harness: no flight of the mutant counts.
held: Of a requirement: the flight did not violate it.  Of a baseline flight: it violates no safety requirement.
holds: Of a find and a mutant: whether they show the fault on seeds that nothing before used.
Holm: The adjustment of p for several safety requirements, or for several finds that are replicated together.
how much: How much of the study `check` looked at.
how sure: How many mutants would be called detected if none had any effect, and how many flights the answer rests on.
Hz: How often a seam is polled each second.
id: The canonical name of a mutant: `GUIDEWORD-parameter@magnitude#phase`.
in the flight: A rail that stands for the flight: X where the fault strikes with a kill, o without one, - where
  nothing puts it to the test.
in the record: Where the record of a command that flies has a signal.
in this campaign: What the flights of the report's campaign say of a mutant in the situation.
in words: The requirement in a sentence.
infect | infected: The fault changed at least one sample.  As a ratio: default mutants that did / flown.
infected_at_s: When the fault changed its first sample [s from take-off].
invalid: The test bench failed in this flight: it counts neither for nor against the mutant.
justification: The argument that somebody still has to write.
key | situation key: The name of a situation: a letter and a value for each axis, such as `T0O0W0D0H1`; lower values
  are more benign.
kill | kills | kill_rate | situations with a kill | killing: A situation where most flights of a detected mutant
  violate a requirement that the unmutated drone holds steadily there.  As k/n: k situations with a kill of n that put
  the mutant to the test.
kill matrix: The table of mutants and situations with what each mutant did in each.
kill_rate_flown: Situations with a kill / situations flown.
killed: A mutant is killed by a requirement in a situation; see kill.  In the table of margins: the mildest magnitude
  that is killed.
killed by | killed_by | shows itself by: The requirements that kill a mutant, or by which a control shows that faults
  reach the drone.
killed in: Situations where the mutant, or these mutants, are killed; in the table of mutants beside those that put it
  to the test.
killed only there: Mutants that are killed in this situation and in no other.
killed so far: Mutants killed in this situation and those above it, of all that are killed anywhere.
killed there: Number of mutants that are killed in this situation.
killed/tested: Mutants killed in the situation / mutants that it puts to the test.
kind: What a violation of the requirement means: safety, operability or reported.
ladder | magnitudes: The magnitudes of a fault that the matrix lists, such as 0.5, 1, 3 and 5 s.
landed: Ending: the drone touched down.
least robustness: The smallest robustness of all flights of the unmutated drone that put the requirement to the test.
likelihood: For the team, by its own risk matrix.
loads: Whether the plugin can be loaded.
look | looks: A time at which a growing campaign is judged; each look spends a part of alpha.
lost: Mutants that are killed somewhere, but not in these situations.
magnitude: How strong a fault is, such as a delay of 3 s.  As the next step: fly a larger one.
margin: The smallest magnitude of a fault that is killed: `1-3 s`: 1 s survives, 3 s is killed; `> 5 s`: nothing flown
  is killed; `<= 0.5 s`: nothing milder was flown; `!`: not monotone.  In the table of finds: what nine in ten
  baselines reach in robustness.
masked: Status: samples were changed, and the drone flew the same to the bit.
meaning: What the value beside it says.
message: The type of the samples of a seam, with named fields.
minimal | minimal mutants | minimal so far: Mutants that no other mutant subsumes: who kills these kills all.
mission: Of a find: flights of the unmutated drone that hold every operability requirement and meet every axis value.
mixed: No short condition describes the situations with a kill; `scaloft-fi kills ID` lists them.
monotone: A stronger magnitude is killed wherever a milder one is.
mutant | mutants: A drone with one fault: a cell, an operator, a magnitude and a time.
mutants killed, of those put to the test: Mutants killed in the situation / mutants that it puts to the test.
mutation score | mutation_score: Default mutants that safety requirements detect / default mutants flown.
NASA GSFC | TCAS | browser | medical devices | network sec. | server: Software whose failures NIST counted by the
  number of inputs that decide them; it stands beside the kill orders.
near: A person is within 3 m of the drone in a free straight line; of requirements, their definition.
needed | would decide: Of a situation: without it a kill is lost.  Of an undecided mutant: how many seeds would
  decide.
needs: What an operator requires of a message; it fits every seam whose message has that.
never tests | never triggered: The condition of this requirement never comes true in the situation.
next | what next: What to do next, most useful first.
no effect here | without effect: A mutant whose every flight equals the baseline's to the bit, in this campaign.
no test | no_test: No safety requirement is steady in the situation, so nothing that a mutant does there counts.
node | study node: The stages of the stack between which a parameter flows.
not claimed: What somebody might read from the figures, and what they do not say.
not detected | not_detected | not shown: Verdict: the mutant was put to the test, and nothing was seen.
not flown | not_flown: No flight of it counts.
not meaningful | not_meaningful: A cell whose guideword makes no new deviation of its parameter; the matrix gives the
  reason.
not tested | not_tested: Verdict: the mutant changes no sample where the unmutated drone holds a safety requirement
  steadily.
not_infected | not infected: Status: every sample passed the fault unchanged.
not_reached | not reached: Status: no sample passed the fault's seam.
note | notes: A finding of `check` that somebody should know; the study can be flown.
number: How many.
of: What the part is a part of.
open: Of a flight: it ended before the requirement was judged.  Of a pair: that happens in more than a tenth of the
  baseline's flights. Of a survivor: nobody accepted it, so the ratchet fails.
operability: A kind of requirement: the drone does its work.  It has a score of its own and is in no safety ratio.
operator | operators: The function that makes faulty samples of true ones, such as `delay`.
oracle: What judges a flight: the requirements.  As the next step: add or sharpen a requirement.
order | kill order: The fewest axes whose values decide whether a mutant is killed; a range where situations say
  nothing.
others: How many more of the sought mutants the find shows.
outcome: What the store keeps of a flight.
owner: Who answers for a disposition.
p: The chance of as many violations if the mutant did nothing, adjusted for several requirements (Holm).
p = 1 | p = 0.75 | p = 0.5 | p =: Choices of t axes of which at least this share of the combinations was flown, of all
  choices.
package: A package of Python.
pair | pairs: A situation with a requirement; the baseline pool says its state: steady, red, unsteady, open, vacuous
  or unknown.
parameter: A quantity that flows between two stages of the stack, or a setting, of which the guidewords are asked.
part: A part of the platform or of the test bench.
part/whole: A ratio as counted; n/a when the whole is 0.
phase: When a fault strikes: a shift in time (`#5s`) or an event (`#waypoint`).
place: The file and line of a study where something stands, or is to be mended.
PLACEBO: A mutant that changes nothing; its flights must equal the baseline's to the bit.
planned: Flights that the run asked for.
platform: Processor, system and package versions; on one platform flights repeat to the bit.
plugin: A package that adds an operator, a stack, a sensor, a format or the like.
population: What a ratio counts, and of what.
predicted: What the study expects of the cell, written before it was flown.
propagate: The fault's changed samples change the flight.  Stopped at propagate: they did not.
put to the test | tests | tested | tested by | tested in: A situation tests a mutant that changes a sample there, if a
  safety requirement is steady there.
question: The question that the sentence beside it answers.
range: An axis whose value is any number between two ends.
ratchet: The gate that lets only those survivors pass that a disposition accepts.
ratio: A part of a whole, such as the mutation score.
rationale | reason: Why it is so: why a cell is not meaningful, what the study predicts, why a survivor is accepted.
reach | reached: A sample passed the fault's seam.
realised: In some baseline flight of the situation, the value of every axis came true: the person was met, the light
  was off.
recommendation: What should be done; for the team.
record: What a drone or a simulator wrote of a flight; `judge` reads it.
red: Of a pair: most flights of the unmutated drone violate the requirement.  It is a finding about the drone, and
  tests no fault.
red flights: Baseline flights that violate a safety requirement / flown.
REDRAW | redraws: Other flights of the unmutated drone, judged as if they were a mutant: how often is nothing called
  detected.
redundant: Killed magnitudes and phases of a cell that are killed exactly where another of them is.
remedy: What to do about a finding.
repeat: Next step: fly it again, because the test bench failed.
reported: A kind of requirement: a violation is shown and decides nothing.
requirement | requirements: What the drone must do, as a formula over the flight; SR: safety, OP: operability.
responsible: Who does the action; for the team.
reveal | revealed: Status: the flight violates a safety requirement that the unmutated drone with the same seed held
  up to then.  An observation, not a verdict.  Stopped at reveal: the flight changed, and nothing is violated more
  often than chance explains.
revealed_by: The requirements that a flight violates and its baseline holds.
robustness | rho: How far a flight is from violating a requirement, in the requirement's unit; below 0 it is violated.
safeguards | existing safeguards: What protects already; for the team.
safety: A kind of requirement: a violation can kill a mutant.
same kills: Mutants of the cell that are killed in exactly the same situations.
seam | seams: The place in the stack where a fault is patched in: the edge between two stages, or a setting of a
  stage.
seed | seeds | --choose-seed: The number that fixes the noise of a flight; another seed is another flight.  As the
  next step: fly more seeds.
seeds of the mutants: Seeds with which mutants were flown in the situation.
seeds of the unmutated drone: Seeds with which the unmutated drone was flown in the situation.
seek | search: The verb that looks for situations which show survivors.
seen: A steady requirement is violated, but not often enough to call the mutant detected.
selected: The score uses situations that were chosen because they show faults, so it speaks of no other situations.
severity: How bad the consequence of a deviation is: a class of the study's own list, which enters no ratio.  Of a
  finding of `check`: error or note.
shard: One of N parts of a run that is flown on several machines; `merge` joins them.
share: The part in a hundred of the whole.
shows: The mutants that a found situation shows.
signal: A number of the flight log, sampled 20 times a second; requirements are formulas over signals.
signature: What tells two breaks apart: requirement, what is struck, where, and which belief was wrong.
situation | situations: One value for each axis: where and how a drone flies, such as dark with a person.
situations flown | situations_flown: Situations with at least one flight that counts.
spread: Standard deviation of the robustness over the baselines.
SR1 | SR2 | OP1: The requirements of the reference study: the drone touches nothing; near a person it is slow and
  touches nobody; it passes every waypoint and is home in time.
stack: The software under test: perception, estimation, planning and control of the drone.
stage | rung: How far a fault gets: reach (a sample passes), infect (it is changed), propagate (the flight changes),
  reveal (a requirement shows it).
stale: Of a flight: its inputs have changed, so it does not count.  Of a disposition: the mutant is detected now, so
  it can go.
state: How a pair or a survivor stands.
status: Of a flight: how far the fault got, from not_reached to revealed.  Of a cell: credible, control or not
  meaningful.
steady: Of a pair: the unmutated drone holds the requirement in at least nine of ten flights.  Only here a fault is
  put to the test.
stopped at | stopped_at: The stage at which a survivor's fault stopped: reach, infect, propagate or reveal.
strength | t: How many axes are combined.
strikes: What the drone touches.
struck: Ending: the drone touched something.  As a column: the body that it touched.
study: A folder with `hazop/`, `mutants/` and `sim/`: everything that a user edits.
subject: What is flown: the unmutated drone, PLACEBO or a mutant.
subsumed by: The mutants directly above: whoever kills one of them kills this one too.
subsumption | subsumes: One mutant subsumes another when the other is killed wherever the first is.
suite | smallest set of situations: The fewest situations that keep every kill.
survive | survived | survives: Status of a flight: it changed, and no safety requirement is violated.  In the table of
  margins: the strongest magnitude that survives, below those that are killed.
survives in: Number of situations that put the mutant to the test and do not kill it.
survivor | survivors: A mutant that is not detected.
t-way | t_way: Combinations of values of t axes; 2-way 100 %: every two values of different axes were flown together.
threshold: The magnitude from which a fault is killed; see margin.
timed_out: Ending: the drone was still flying at the time limit.
times triggered: Episodes in which the requirement's condition came true.
title: A name for people.
too few seeds to say | too few seeds | too_few_seeds: Without some seed the flights of a detected mutant that remain
  could not be detected, whatever they show.
triggered: The requirement's condition came true, so that the flight tests it.
trivial: A detected mutant that is killed in nine tenths of the situations that put it to the test, or within 5 s of
  take-off: any test would show it.
uncovered: A survivor survives in a situation that its disposition does not name: the ratchet fails.
undecided: Verdict: violations were seen, or too few flights were flown to decide; the row says how many seeds would.
unit: The unit of a number.
unknown: Of a pair: the situation has fewer than ten baseline flights, so nothing is known of chance there.
unsteady: Of a pair: the unmutated drone holds the requirement or not by chance, so it tests no fault.
untested: A disposition whose mutant is not put to the test now.
used in: Whether a signal may stand in requirements, in the predicates `realised` of axes, or in neither yet.
vacuous: Of a flight: the requirement's condition never came true, so nothing is said.  Of a pair: that is so in most
  baseline flights.
value | values: What an axis has in a situation; in a list, what the thing beside it is.
verdict: What all flights of a mutant show together: detected, undecided, not detected or not tested.
version: Of a package, a plugin or a part of the platform.
violated: The requirement did not hold.  In tables: how often, or which requirements.
violated_at_s | violated at: When the requirement was first violated [s from take-off].
violates | the unmutated drone violates: The requirement that is violated, and in how many of the flights.
violation_bodies: What was touched at each of these moments; empty for nothing.
violation_times_s: When each requirement in `violated` was first violated [s from take-off], in the same order.
waiting: Status of a flight whose baseline, of the same situation and seed, is not flown yet or does not count any more.
warning: A violation that is printed when it happens; it is no verdict.
what: The thing that the value beside it is about.
what it does: The change that an operator makes to samples.
where: In which situations, as the shortest condition; of a break, where in the mine.
which: The members, by name.
why: The reason.
with a kill/flown: Mutants with a kill in the situation / mutants flown there.
with a kill/tested: Mutants with a kill in the situation / mutants that it puts to the test.
wrong belief: The stage that was the most wrong in the last second before, and by how much.
x | y | z: Position [m]: x east, y along the main corridor, z up, home at (0, 0, 0).
"""


@dataclass(frozen=True)
class Term:
    """A word of the output.

    Attributes:
        name: as it is printed.
        meaning: in one or a few sentences.
        also: other forms that are printed, such as the plural, the head of a column, or the value in a file.
    """

    name: str
    meaning: str
    also: tuple[str, ...] = ()


def _terms(text: str) -> tuple[Term, ...]:
    r"""The terms of a text: `name | other form: meaning` on a line, its further lines indented.

    >>> _terms("kill | kills: Most flights\n  violate.\n")
    (Term(name='kill', meaning='Most flights violate.', also=('kills',)),)
    """
    entries = text.replace("\n  ", " ").strip().splitlines()
    parts = (entry.partition(": ") for entry in entries)
    return tuple(
        Term(*(name, meaning), tuple(also)) for names, _, meaning in parts for name, *also in [names.split(" | ")]
    )


TERMS = _terms(GLOSSARY)
"""Every term, in alphabetical order."""


@cache
def term(text: str) -> Term | None:
    """The term that has this name or other form, whatever its capitals; None when the glossary has none.

    >>> term("Kills").name
    'kill'
    """
    return _by_form().get(text.casefold())


@cache
def _by_form() -> dict[str, Term]:
    return {form.casefold(): term for term in TERMS for form in (*term.also, term.name)}
