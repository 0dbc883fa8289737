"""The façade: what `import tgvdp` offers."""

from tgvdp.api.methods import Fastest
from tgvdp.api.result import SearchResult
from tgvdp.api.run import search
from tgvdp.api.score import Score, score_run
from tgvdp.methods.budget import SearchBudget

__all__ = ["Fastest", "Score", "SearchBudget", "SearchResult", "score_run", "search"]
