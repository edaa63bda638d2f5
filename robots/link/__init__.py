"""The link between service and robots: a channel that may lose, delay or repeat messages. `robots.link.mqtt` has one
over a broker.
"""

from robots.link.channel import InMemoryLink, Link, LinkClosed, PipeLink

__all__ = ["InMemoryLink", "Link", "LinkClosed", "PipeLink"]
