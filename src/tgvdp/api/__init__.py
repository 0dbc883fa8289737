"""The façade: what `import tgvdp` offers."""

from tgvdp.api.journey_result import JourneyResult
from tgvdp.api.journeys import journey
from tgvdp.api.methods import Fastest
from tgvdp.api.result import SearchResult
from tgvdp.api.run import search
from tgvdp.api.score import Score, score_run
from tgvdp.methods.budget import SearchBudget

__all__ = ["Fastest", "JourneyResult", "Score", "SearchBudget", "SearchResult", "journey", "score_run", "search"]
