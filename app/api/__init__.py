"""The HTTP API: routes, bodies, problems and streams. Routes call the desks in `app`, and hold no rules of their own."""
