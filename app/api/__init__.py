"""The HTTP API: routes, bodies, problems, streams. Routes call desks and hold no rules of their own."""
