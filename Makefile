# make demo: set up, run a short session from pictures, leave a video, a figure and a summary.
# make test: set up, run the tests.
PYTHON ?= python3
BIN := .venv/bin
OUT ?= out/demo
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
RENDERS := $(BIN)/python -c "import jointattn_mj, mujoco; mujoco.GLContext(8, 8).make_current()" >/dev/null 2>&1

.PHONY: demo test setup trained check docs
.DEFAULT_GOAL := demo

demo: setup
	rm -rf $(OUT)
	$(BIN)/jointattn session --minutes 3 --seed 0 --video --video-every 2 --out $(OUT)
	$(BIN)/jointattn session --minutes 0.5 --seed 1 --start-from assets/trained/robin.npz --video --video-every 2 --out $(OUT)/trained
	@echo
	@echo "Three minutes of a robot that begins to learn:  $(OUT)/video.mp4"
	@echo "The same robot after 26 minutes of learning:    $(OUT)/trained/video.mp4"
	@echo "Success over time, faces it knows, numbers:     $(OUT)/success.png  $(OUT)/som.png  $(OUT)/summary.json"

test: setup
	$(BIN)/python -m pytest -n 2

check: setup
	$(BIN)/ruff check .
	$(BIN)/mypy

# The site, in out/site; a warning is an error.
docs: setup
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "Documentation: out/site/index.html"

# What `make demo` continues from: a robot after one session of chapter 6.
trained: setup
	$(BIN)/jointattn session --minutes 26 --seed 0 --out out/trained
	mkdir -p assets/trained && cp out/trained/weights.npz assets/trained/robin.npz

# Software OpenGL renders without a screen; pip cannot bring it.
setup: .venv/.ready
	@$(RENDERS) || { \
	  command -v apt-get >/dev/null || { echo "Please install Mesa's EGL or OSMesa: pictures are rendered with it."; exit 1; }; \
	  $(SUDO) apt-get update -qq && $(SUDO) apt-get install -y -qq --no-install-recommends libegl1 libopengl0 libgl1-mesa-dri; \
	  $(RENDERS) || { echo "OpenGL is installed, but nothing can be rendered: see README, Troubles."; exit 1; }; }

.venv/.ready: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --disable-pip-version-check --quiet --editable '.[dev]'
	touch $@
