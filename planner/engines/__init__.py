"""Planning engines: hierarchical (our own), Fast Downward, temporal planners, and the portfolio of them."""
