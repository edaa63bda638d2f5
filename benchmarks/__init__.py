"""Figures of how well Macta does; nothing here is asserted."""

from robots.kernels import install

install()
