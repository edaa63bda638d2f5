# The service with its embedded simulation, on Debian's Python 3.11.
FROM python:3.11-slim-bookworm
WORKDIR /srv/macta
RUN pip install --no-cache-dir uv && useradd --create-home macta && mkdir /data && chown macta /data
COPY --chown=macta . .
RUN chown macta .
USER macta
RUN uv sync --no-default-groups
# Where the planner's compiled inner loop is kept; compiled here, so that no start has to wait for it.
ENV XDG_CACHE_HOME=/home/macta/.cache
RUN uv run --no-sync python -c "from robots.kernels import install; install(); from planner import load_knowledge_base as base; from planner.engines.registry import portfolio; portfolio(base()).warm_up()"
ENV MACTA_DATA=/data MACTA_HOST=0.0.0.0 PATH=/srv/macta/.venv/bin:$PATH
EXPOSE 8000
HEALTHCHECK CMD ["python", "-c", "import urllib.request as u; u.urlopen('http://127.0.0.1:8000/readyz')"]
CMD ["macta", "serve"]
