"""Learned durations: how long actions take in a world, as factors of what the knowledge base expects of them."""

from app.durations.book import key_of, learn, learned_durations
from app.durations.learned import PRIOR, Durations, Kind, Learned

__all__ = ["PRIOR", "Durations", "Kind", "Learned", "key_of", "learn", "learned_durations"]
