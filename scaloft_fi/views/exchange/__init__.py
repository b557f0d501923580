r"""The campaign in the formats of other tools, each a pure function of the same dossier.

A format is one function in a file of this folder, or in a package that names its module in the entry-point group
`scaloft_fi.plugins`:

    from scaloft_fi.views.exchange import Dossier, export_format

    @export_format("killed-ids", "ids of the detected mutants, one a line")
    def killed_ids(dossier: Dossier) -> str:
        return "".join(f"{mutant.subject.id}\n" for mutant in dossier.score.mutants if mutant.detected)
"""

from importlib import import_module
from pkgutil import iter_modules

from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import FORMATS, ExportFormat, export_format

__all__ = ["FORMATS", "Dossier", "ExportFormat", "export_format"]

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")
