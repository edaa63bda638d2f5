# The service with its embedded simulation, on Debian's Python 3.11.
FROM python:3.11-slim-bookworm AS installation
RUN apt-get update && apt-get install --yes --no-install-recommends binutils && pip install --no-cache-dir uv
COPY . /source
RUN UV_PYTHON=/usr/local/bin/python3 sh /source/examples/install_production.sh /srv/macta

FROM python:3.11-slim-bookworm
RUN useradd --create-home macta && mkdir /data && chown macta /data
COPY --from=installation /srv/macta /srv/macta
USER macta
WORKDIR /data
# Where the planner's compiled inner loop is kept; compiled here, so that no start has to wait for it.
ENV PATH=/srv/macta/bin:$PATH XDG_CACHE_HOME=/home/macta/.cache
RUN python -c "from robots.kernels import install; install(); from planner import load_knowledge_base as base; from planner.engines.registry import portfolio; portfolio(base()).warm_up()"
ENV MACTA_DATA=/data MACTA_HOST=0.0.0.0
EXPOSE 8000
HEALTHCHECK CMD ["python", "-c", "import urllib.request as u; u.urlopen('http://127.0.0.1:8000/readyz')"]
CMD ["macta", "serve"]
