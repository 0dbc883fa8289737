"""The façade: what `import tgvdp` offers."""

from tgvdp.api.methods import Fastest
from tgvdp.api.result import SearchResult
from tgvdp.api.run import search

__all__ = ["Fastest", "SearchResult", "search"]
