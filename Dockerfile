# The HTTP service.    docker build -t attitude .  &&  docker run -p 8000:8000 attitude
ARG PYTHON_IMAGE=python:3.11-slim


# -- build: a virtual environment, and the kernel compiled ----------------------------------------
FROM ${PYTHON_IMAGE} AS build

ENV PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_ROOT_USER_ACTION=ignore
# Without pip of its own: the image's pip installs into it, and none is carried along.
RUN ["python", "-m", "venv", "--without-pip", "/opt/attitude"]
WORKDIR /src

# Dependencies in a layer of their own, which stays cached while the project's code changes.
COPY pyproject.toml ./
RUN python -c "import tomllib; project = tomllib.load(open('pyproject.toml', 'rb'))['project']; \
extras = project['optional-dependencies']; print(*project['dependencies'], *extras['service'], *extras['orbit'], sep='\n')" >requirements.txt \
 && python -m pip --python /opt/attitude/bin/python install -r requirements.txt

COPY README.md LICENSE ./
COPY attitude attitude
COPY service service
RUN ["python", "-m", "pip", "--python", "/opt/attitude/bin/python", "install", "--no-deps", "."]

# Compiled kernels are found again by their sources, the compiler's version and the processor; they
# are kept beside the sources, so in the final stage they are loaded, not compiled. The warm-up
# also computes the service's known case, and the build fails if it comes out wrong.
WORKDIR /
RUN ["/opt/attitude/bin/python", "-c", "from service import readiness; print(readiness.warm_up())"]


# -- what runs ------------------------------------------------------------------------------------
FROM ${PYTHON_IMAGE}

LABEL org.opencontainers.image.title="attitude" \
      org.opencontainers.image.description="Exact attitude ephemerides of freely rotating bodies, over HTTP" \
      org.opencontainers.image.licenses="BSD-3-Clause"

# The base image's installers are of no use to a service that installs nothing.
RUN ["python", "-m", "pip", "uninstall", "--yes", "--quiet", "--root-user-action=ignore", "pip", "setuptools", "wheel"]

COPY --from=build /opt/attitude /opt/attitude
# On another kind of processor than the build's the kernels are compiled anew, and kept here.
RUN ["python", "-c", "import os; os.makedirs('/var/cache/attitude'); os.chown('/var/cache/attitude', 10001, 10001)"]

ENV PATH=/opt/attitude/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    XDG_CACHE_HOME=/var/cache \
    ATTITUDE_HOST=0.0.0.0 \
    ATTITUDE_PORT=8000
USER 10001:10001
WORKDIR /
EXPOSE 8000

# Alive, not ready: a container that is still compiling is not to be killed for it.
HEALTHCHECK --interval=10s --timeout=3s --start-period=30s --retries=3 \
  CMD ["python", "-c", "import os; from urllib.request import ProxyHandler, build_opener as build; build(ProxyHandler({})).open('http://127.0.0.1:' + os.environ['ATTITUDE_PORT'] + '/healthz', timeout=2)"]

CMD ["attitude", "serve"]
