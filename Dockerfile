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
# Where compiled functions are kept; compiled here, so that every start is at full speed.
ENV PATH=/srv/macta/bin:$PATH XDG_CACHE_HOME=/home/macta/.cache
RUN python -c "from robots.kernels import install; install(); from app.planning.pool.work import PLANNER; from sim.process.first_calls import SIMULATION; from robots.compilation import compile_once; [compile_once(group, print) for group in (PLANNER, SIMULATION)]"
ENV MACTA_DATA=/data MACTA_HOST=0.0.0.0
EXPOSE 8000
HEALTHCHECK CMD ["python", "-c", "import urllib.request as u; u.urlopen('http://127.0.0.1:8000/readyz')"]
CMD ["macta", "serve"]
