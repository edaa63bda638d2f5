"""Measures how well Macta performs; asserts nothing."""

from robots.kernels import install

install()
