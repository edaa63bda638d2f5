"""`python -m robots.adapters.vda5050`: the same as `macta-robot vda5050`."""

from robots.adapters.vda5050.command import main

raise SystemExit(main())
