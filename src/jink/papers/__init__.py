"""The five papers that jink reproduces: `PAPERS` by name, one file per paper; :func:`run` measures one."""

from .choi_2001 import CHOI_2001
from .lee_2002 import LEE_2002
from .lee_2003 import LEE_2003
from .paper import Experiment, Metric, Paper, Row
from .run import Outcome, run
from .titi_guney import TITI_GUNEY
from .wang_2010 import WANG_2010

PAPERS: dict[str, Paper] = {p.name: p for p in (LEE_2003, LEE_2002, WANG_2010, CHOI_2001, TITI_GUNEY)}

__all__ = ["PAPERS", "Experiment", "Metric", "Outcome", "Paper", "Row", "run"]
