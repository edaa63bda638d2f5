"""Learned durations: mean and spread of the ratio of actual to expected duration. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt

MAX_SAMPLES = 100
"""Beyond this count older samples fade exponentially, to follow a world that changes (our choice)."""
PRIOR_SAMPLES = 3.0
"""Weight of the knowledge base's expectation, ratio 1, in samples (our choice)."""
PRIOR_SPREAD = 0.3
"""Standard deviation of the ratio before the first sample (our choice)."""
MIN_RATIO = 0.25
MAX_RATIO = 4.0
"""Ratios are clamped to this range, so that one odd packet does not dominate (our choice)."""

Kind = tuple[str, int]
"""An action's tag and the number of robots that do it together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Learned:
    """Running mean and variance of the ratio of actual to expected duration (Welford 1962), and their use.

    Once `samples` has reached `MAX_SAMPLES` the mean and the variance are exponentially weighted.
    """

    samples: int = 0
    mean: float = 1.0
    variance: float = 0.0

    def with_sample(self, ratio: float) -> "Learned":
        """The estimate after one more action took `ratio` times its expected duration."""
        ratio = min(max(ratio, MIN_RATIO), MAX_RATIO)
        samples = min(self.samples + 1, MAX_SAMPLES)
        weight = 1 / samples
        surprise = ratio - self.mean
        return Learned(
            samples=samples,
            mean=self.mean + weight * surprise,
            variance=(1 - weight) * (self.variance + weight * surprise**2),
        )

    @property
    def factor(self) -> float:
        """Factor on the expected duration: the mean, drawn towards 1 by the prior."""
        return (PRIOR_SAMPLES + self.samples * self.mean) / (PRIOR_SAMPLES + self.samples)

    @property
    def spread(self) -> float:
        """The standard deviation of the ratio, of samples and prior pooled; the prior's own without samples."""
        weight = self.samples / (PRIOR_SAMPLES + self.samples)
        within = weight * self.variance + (1 - weight) * PRIOR_SPREAD**2
        return sqrt(within + weight * (1 - weight) * (self.mean - 1) ** 2)

    @property
    def relative_spread(self) -> float:
        """The spread as a part of the expected duration times the factor."""
        return self.spread / self.factor


PRIOR = Learned()
Durations = Mapping[Kind, Learned]
