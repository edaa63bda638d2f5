"""What actual durations teach: the ratio of actual to expected, its mean and its spread. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt

MEMORY = 100
"""So many samples count at most; older ones fade, so that a world that changes is learned anew (our choice)."""
PRIOR_SAMPLES = 3.0
"""The knowledge base's expectation, ratio 1, weighs as much as this many samples (our choice)."""
PRIOR_SPREAD = 0.3
"""The spread of the ratio that is expected before anything is seen (our choice)."""
EXTREMES = (0.25, 4.0)
"""A ratio beyond these counts as these: one odd packet must not rule (our choice)."""

Kind = tuple[str, int]
"""An action's tag and the number of robots that do it together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Learned:
    """Running mean and variance of the ratio of actual to expected duration (Welford 1962), and their use.

    Once `samples` has reached the memory's size the mean and the variance are exponentially weighted.
    """

    samples: int = 0
    mean: float = 1.0
    variance: float = 0.0

    def with_sample(self, ratio: float) -> "Learned":
        """What is known after one more action took `ratio` times its expected duration."""
        ratio = min(max(ratio, EXTREMES[0]), EXTREMES[1])
        samples = min(self.samples + 1, MEMORY)
        weight, surprise = 1 / samples, ratio - self.mean
        return Learned(
            samples=samples,
            mean=self.mean + weight * surprise,
            variance=(1 - weight) * (self.variance + weight * surprise**2),
        )

    @property
    def factor(self) -> float:
        """What to multiply the expected duration by: the mean, drawn towards 1 by the prior."""
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
