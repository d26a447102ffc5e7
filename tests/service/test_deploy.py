"""What runs the service elsewhere agrees with the service: image, manifest, proxy, and the tables of docs."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
from fnmatch import fnmatch
from pathlib import Path

import pytest
import yaml

from service.deadline import GRACE_S
from service.settings import Settings, table, variable

ROOT = Path(__file__).parents[2]
DOCKERFILE = (ROOT / "Dockerfile").read_text()
NGINX = (ROOT / "docs" / "deploy" / "nginx.conf").read_text()
SETTINGS = {variable(name): field.default for name, field in Settings.model_fields.items()}
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs" / name for name in ("service.md", "http.md", "installation.md"))]
NAMED = [*ROOT.glob("docs/deploy/*"), ROOT / "Dockerfile", *PAGES]
# The library's own, and one that was a setting once.
OTHERS = {"ATTITUDE_CACHE_DIR", "ATTITUDE_PLAIN_NUMBA", "ATTITUDE_DRAIN_SECONDS"}


@pytest.fixture(scope="module")
def manifest():
    documents = yaml.safe_load_all((ROOT / "docs" / "deploy" / "kubernetes.yaml").read_text())
    return {document["kind"]: document for document in documents}


@pytest.fixture(scope="module")
def pod(manifest):
    return manifest["Deployment"]["spec"]["template"]["spec"]


@pytest.fixture(scope="module")
def container(pod):
    (container,) = pod["containers"]
    return container


def test_settings_table_is_that_of_the_settings():
    """Printed by: python -m service.settings"""
    assert f"\n\n{table()}\n\n" in (ROOT / "docs" / "service.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", NAMED, ids=[str(path.relative_to(ROOT)) for path in NAMED])
def test_variables_that_are_named_are_settings(path):
    named = set(re.findall(r"ATTITUDE_[A-Z_]+[A-Z]", path.read_text(encoding="utf-8")))
    assert named <= SETTINGS.keys() | OTHERS


# -- image ----------------------------------------------------------------------------------------


def test_image_is_copied_from_files_that_are_let_in():
    ignored = (ROOT / ".dockerignore").read_text().split()
    allowed = [line.removeprefix("!") for line in ignored if line.startswith("!")]
    copied = re.findall(r"^COPY ((?!--from).*) \S+$", DOCKERFILE, flags=re.MULTILINE)
    for path in (path for line in copied for path in line.split()):
        assert (ROOT / path).exists()
        assert any(fnmatch(path, pattern) for pattern in allowed), path


def test_image_runs_as_the_user_and_at_the_port_that_the_manifest_says(pod, container):
    user, group = re.search(r"^USER (\d+):(\d+)$", DOCKERFILE, flags=re.MULTILINE).groups()
    assert (pod["securityContext"]["runAsUser"], pod["securityContext"]["runAsGroup"]) == (
        int(user),
        int(group),
    )
    (port,) = container["ports"]
    assert f"ATTITUDE_PORT={port['containerPort']}" in DOCKERFILE


# -- Kubernetes -----------------------------------------------------------------------------------


def test_manifest_has_what_a_deployment_needs(manifest):
    assert set(manifest) == {
        "Secret",
        "Deployment",
        "Service",
        "HorizontalPodAutoscaler",
        "PodDisruptionBudget",
    }
    labels = manifest["Deployment"]["spec"]["template"]["metadata"]["labels"]
    for selector in (
        manifest["Deployment"]["spec"]["selector"]["matchLabels"],
        manifest["Service"]["spec"]["selector"],
        manifest["PodDisruptionBudget"]["spec"]["selector"]["matchLabels"],
    ):
        assert selector == labels
    assert (
        manifest["HorizontalPodAutoscaler"]["spec"]["scaleTargetRef"]["name"]
        == manifest["Deployment"]["metadata"]["name"]
    )


def test_probes_ask_routes_that_are_there_and_need_no_token(container, client):
    paths = {
        name: container[f"{name}Probe"]["httpGet"]["path"] for name in ("startup", "readiness", "liveness")
    }
    assert paths == {"startup": "/readyz", "readiness": "/readyz", "liveness": "/healthz"}
    for path in paths.values():
        assert client.get(path).status_code == 200
    (port,) = container["ports"]
    assert all(container[f"{name}Probe"]["httpGet"]["port"] == port["name"] for name in paths)


def test_pod_has_time_to_finish_what_it_accepted(pod, container):
    command, seconds = container["lifecycle"]["preStop"]["exec"]["command"]
    assert command == "sleep"
    longest = int(seconds) + SETTINGS["ATTITUDE_MAX_SECONDS"] + GRACE_S
    assert pod["terminationGracePeriodSeconds"] > longest


def test_pod_may_do_nothing_it_need_not(pod, container):
    assert pod["enableServiceLinks"] is False
    assert pod["automountServiceAccountToken"] is False
    assert pod["securityContext"]["runAsNonRoot"] is True
    assert pod["securityContext"]["seccompProfile"] == {"type": "RuntimeDefault"}
    assert container["securityContext"] == {
        "allowPrivilegeEscalation": False,
        "readOnlyRootFilesystem": True,
        "capabilities": {"drop": ["ALL"]},
    }
    assert {"cpu", "memory"} <= container["resources"]["limits"].keys()


def test_token_is_read_where_its_secret_is_mounted(manifest, pod, container):
    values = {each["name"]: each["value"] for each in container["env"]}
    mounts = {each["name"]: each["mountPath"] for each in container["volumeMounts"]}
    assert mounts["tmp"] == "/tmp"
    (secret,) = (each["secret"]["secretName"] for each in pod["volumes"] if each["name"] == "token")
    assert secret == manifest["Secret"]["metadata"]["name"]
    folder, _, key = values["ATTITUDE_TOKEN_FILE"].rpartition("/")
    assert folder == mounts["token"]
    assert key in manifest["Secret"]["stringData"]


# -- nginx ----------------------------------------------------------------------------------------


def directive(name):
    (value,) = re.findall(rf"^ *{name} +([^;]+);", NGINX, flags=re.MULTILINE)
    return value


def test_proxy_has_the_limits_of_the_service():
    assert directive("client_max_body_size") == f"{SETTINGS['ATTITUDE_MAX_BODY_BYTES'] >> 20}m"
    assert int(directive("proxy_read_timeout").removesuffix("s")) > SETTINGS["ATTITUDE_MAX_SECONDS"]
    assert directive("server(?= 127)") == f"127.0.0.1:{SETTINGS['ATTITUDE_PORT']}"


def test_proxy_passes_blocks_on_as_they_come():
    assert directive("proxy_buffering") == "off"
    assert directive("proxy_http_version") == "1.1"


@pytest.mark.skipif(shutil.which("nginx") is None, reason="nginx is not installed")
def test_nginx_takes_the_example(tmp_path):
    names = ["-subj", "/CN=attitude.example.org", "-keyout", "attitude.key", "-out", "attitude.crt"]
    openssl = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", *names]
    subprocess.run(openssl, cwd=tmp_path, check=True, capture_output=True)
    (tmp_path / "site.conf").write_text(NGINX.replace("/etc/nginx/tls", str(tmp_path)))
    main = f"pid {tmp_path}/pid; events {{}} http {{ include {tmp_path}/site.conf; }}"
    (tmp_path / "nginx.conf").write_text(main)
    command = ["nginx", "-t", "-c", str(tmp_path / "nginx.conf"), "-g", "error_log stderr;"]
    tried = subprocess.run(command, capture_output=True, text=True, check=False)
    assert tried.returncode == 0, tried.stderr


def test_manifest_keeps_to_the_schemas_of_kubernetes():
    validator = pytest.importorskip("kubernetes_validate")
    for document in yaml.safe_load_all((ROOT / "docs" / "deploy" / "kubernetes.yaml").read_text()):
        validator.validate(document, "1.31", strict=True)


@pytest.mark.parametrize("script", ["check.py", "trim.py"])
def test_scripts_of_the_image_find_what_they_import(script):
    runpy.run_path(str(ROOT / "docs" / "deploy" / script), run_name="imported")
