"""The HTTP API: routes, bodies, problems, streams. Routes call services and contain no rules."""
