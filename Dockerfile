# The HTTP service.    docker build -t attitude .  &&  docker run -p 8000:8000 attitude
ARG PYTHON_IMAGE=python:3.11-slim


# -- build: a virtual environment, and the kernels compiled ---------------------------------------
FROM ${PYTHON_IMAGE} AS build

# The linker that makes libraries of the kernels; of a compiler there is numba's, and only here.
RUN apt-get update && apt-get install --yes --no-install-recommends binutils

ENV PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_ROOT_USER_ACTION=ignore
# Without pip of its own: the image's pip installs into it, and none is carried along.
RUN ["python", "-m", "venv", "--without-pip", "/opt/attitude"]
WORKDIR /src

# Dependencies in a layer of their own, which stays cached while the project's code changes.
COPY pyproject.toml ./
RUN python -c "import tomllib; project = tomllib.load(open('pyproject.toml', 'rb'))['project']; \
extras = project['optional-dependencies']; \
print(*project['dependencies'], *(each for name in ('service', 'orbit', 'atmosphere', 'cost') for each in extras[name]), sep='\n')" >requirements.txt \
 && python -m pip --python /opt/attitude/bin/python install -r requirements.txt

COPY README.md LICENSE ./
COPY attitude attitude
COPY service service
RUN ["python", "-m", "pip", "--python", "/opt/attitude/bin/python", "install", "--no-deps", "."]

# Kernels as libraries, for every processor of this architecture; then nothing needs the compiler.
WORKDIR /
RUN ["/opt/attitude/bin/python", "-m", "attitude.runtime.build"]
RUN ["python", "-m", "pip", "--python", "/opt/attitude/bin/python", "uninstall", "--yes", "numba", "llvmlite"]

# What the service never opens goes; what is left computes the known case and writes every format,
# or the build fails.
COPY docs/deploy/trim.py docs/deploy/check.py /src/deploy/
RUN /opt/attitude/bin/python /src/deploy/trim.py /opt/attitude/lib/python3.*/site-packages \
 && /opt/attitude/bin/python /src/deploy/check.py


# -- what runs ------------------------------------------------------------------------------------
FROM ${PYTHON_IMAGE}

LABEL org.opencontainers.image.title="attitude" \
      org.opencontainers.image.description="Exact attitude ephemerides of freely rotating bodies, over HTTP" \
      org.opencontainers.image.licenses="BSD-3-Clause"

# The base image's installers are of no use to a service that installs nothing.
RUN ["python", "-m", "pip", "uninstall", "--yes", "--quiet", "--root-user-action=ignore", "pip", "setuptools", "wheel"]

COPY --from=build /opt/attitude /opt/attitude
# Started once as who may write: what of Python's own library it needs is kept translated.
RUN ["/opt/attitude/bin/python", "-c", "from service import app, readiness; readiness.warm_up()"]

# Only /tmp is ever written to: the root may be read-only.
ENV PATH=/opt/attitude/bin:$PATH \
    HOME=/tmp \
    PYTHONUNBUFFERED=1 \
    PYTHONDONTWRITEBYTECODE=1 \
    ATTITUDE_HOST=0.0.0.0 \
    ATTITUDE_PORT=8000
USER 10001:10001
WORKDIR /
EXPOSE 8000

# Alive, not ready: a container that is still starting is not to be killed for it.
HEALTHCHECK --interval=10s --timeout=3s --start-period=30s --retries=3 \
  CMD ["python", "-S", "-c", "import os; from http.client import HTTPConnection as C; c = C('127.0.0.1', int(os.environ['ATTITUDE_PORT']), timeout=2); c.request('GET', '/healthz'); raise SystemExit(c.getresponse().status != 200)"]

CMD ["attitude", "serve"]
