# The commands of the README. They need Rust (rustup.rs) and make; on Debian and Ubuntu they install what else is missing:
# a C linker, a Vulkan driver where none answers, and for the tests Python with pip, which fetches Open Image Denoise.

CARGO ?= cargo
# What is tested is what releases have: the program with the window of `gpu-rt view`.
BUILD = --release --features window
GPU_RT = $(CARGO) run $(BUILD) --quiet --
WITHOUT_WINDOW = $(CARGO) run --release --quiet --

# `$(call install,PACKAGES,WHY)`: apt-get, as root or through sudo.
define install
{ \
	echo "$(strip $(2)): installing $(strip $(1))"; \
	command -v apt-get >/dev/null || { echo "error: $(strip $(2)), and there is no apt-get here to install it" >&2; exit 1; }; \
	root=; [ "$$(id -u)" = 0 ] || root=sudo; \
	$$root apt-get update -qq && \
	$$root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(1); \
}
endef

.PHONY: render test test-programs driver display oidn wheel test-python pip blender validate test-blender test-blender-window test-page pages bpy quick test-long test-slurm slurm test-tint test-skies test-files fuzz soak test-drivers accuracy gpu gpu-kit gpu-walks gpu-compile lint toolchain

# The cover scene, in 50 s at most: out/weekend.exr is linear, out/weekend.png is for looking at.
render: toolchain
	$(CARGO) build --release
	@$(WITHOUT_WINDOW) devices >/dev/null 2>&1 || $(call install, libvulkan1 mesa-vulkan-drivers, no Vulkan driver answers)
	@mkdir -p out
	$(WITHOUT_WINDOW) render scenes/weekend.ron --size 800x450 --time 50s --spp 4096 -o out/weekend.exr --png out/weekend.png --force

# The tests run on a software driver, which they choose by themselves; GPU_RT_TEST_DEVICE names another device.
# LVP_POISON_MEMORY makes Mesa's software driver fill fresh memory with junk, so that reading what nobody wrote shows.
# `make test-programs PROGRAMS="--test images"` runs some of the test programs alone.
PROGRAMS ?= --lib --bins --tests
test test-programs: export LVP_POISON_MEMORY = true
# Mesa's device-select layer complains on every run where there is no desktop session to ask about GPUs.
test test-programs: export NODEVICE_SELECT = 1
test: test-programs
	$(CARGO) test $(BUILD) --doc
	@$(MAKE) --no-print-directory test-python

test-programs: toolchain oidn display
	$(CARGO) test $(BUILD) --no-run $(PROGRAMS)
	@$(MAKE) --no-print-directory driver
	tests/slowest.sh $(CARGO) test $(BUILD) $(PROGRAMS)

# The package for Python, of the program that the tests build: target/wheels/gpu_rt-VERSION-….whl. Its name has the oldest
# glibc that it runs with, so that pip refuses it elsewhere.
wheel: toolchain pip
	rm -rf target/wheels
	MATURIN_PEP517_ARGS="--compatibility pypi --features window" python3 -m pip wheel --quiet --no-deps --wheel-dir target/wheels .

# What users of the wheel get: it is installed into an empty environment, and tested there with nothing else on PATH, Rust neither.
PYTHON_TESTS ?= discover --start-directory tests/python
test-python: export NODEVICE_SELECT = 1
test-python: wheel driver
	rm -rf target/python
	python3 -m venv target/python
	target/python/bin/pip install --quiet target/wheels/*.whl -r tests/python/requirements.txt
	PATH="$(CURDIR)/target/python/bin" target/python/bin/python -B -m unittest $(PYTHON_TESTS)

# The extension for Blender, which holds no program: target/blender/gpu_rt-VERSION.zip, packed and validated by Blender's own command, which
# leaves out links: ron.py is that of the Python package.
EXTENSION = target/bpy/bin/python $$(ls target/bpy/lib/python3.*/site-packages/bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py)
blender: bpy
	rm -rf target/blender && mkdir -p target/blender
	cp -RL blender/gpu_rt target/blender/gpu_rt
	$(EXTENSION) build --source-dir target/blender/gpu_rt --output-dir target/blender
	@$(MAKE) --no-print-directory validate ZIP="$$(ls target/blender/*.zip)"

validate:
	$(EXTENSION) validate $(ZIP)

# The extension in Blender's Python module, with this program.
BLENDER_TESTS ?= test_extension
test-blender: export NODEVICE_SELECT = 1
test-blender: toolchain blender driver
	$(CARGO) build $(BUILD)
	PATH="$(CURDIR)/target/release:$$PATH" PYTHONPATH=tests/blender \
		target/bpy/bin/python -B -W ignore::DeprecationWarning -m unittest $(BLENDER_TESTS)

# The 3D view in a window of Blender: as root, Debian 13 with Blender (1.3 GB) goes into target/blender-window.
test-blender-window: toolchain
	$(CARGO) build $(BUILD)
	@command -v debootstrap >/dev/null || $(call install, debootstrap debian-archive-keyring, no debootstrap installs Debian 13)
	@root=; [ "$$(id -u)" = 0 ] || root=sudo; $$root tests/blender/window.sh

# Pages in Dawn and in Chromium, which also brings the software driver that all of these tests have.
test-page: toolchain
	@command -v npm >/dev/null || $(call install, nodejs npm, no node answers)
	@command -v chromium >/dev/null || $(call install, chromium, Chromium is missing)
	cd tests/page && npm ci --silent
	$(CARGO) build $(BUILD)
	PATH="$(CURDIR)/target/release:$$PATH" node --test tests/page/dawn.test.mjs
	PATH="$(CURDIR)/target/release:$$PATH" node --test tests/page/browser.test.mjs

# Pages of some scenes, with an index, for a server of files: target/pages.
PAGES = weekend.ron cornell.ron glass.ron lights.ron still-life.glb window.ron motion.ron
pages: toolchain
	$(CARGO) build $(BUILD)
	@set -e; for scene in $(PAGES); do to=target/pages/$${scene%%.*}; echo "$$to"; $(GPU_RT) page scenes/$$scene -o $$to; done
	@{ echo '<!doctype html><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>gpu-rt</title>'; \
		echo '<h1>Scenes that render themselves</h1>'; \
		for scene in $(PAGES); do name=$${scene%%.*}; \
			echo "<p><a href=\"$$name/\"><img src=\"$$name/picture.png\" alt=\"$$name\" width=\"320\"></a>"; done; } >target/pages/index.html

# Blender as a Python module (350 MB, by pip), which is made for two versions of Python. Debian lacks some of the libraries that it loads.
bpy: pip
	@cmp -s tests/blender/requirements.txt target/bpy/requirements.txt || { \
		rm -rf target/bpy; \
		for python in python3 python3.11 python3.13; do \
			$$python -c 'import sys, ensurepip; sys.exit(sys.version_info[:2] not in ((3, 11), (3, 13)))' 2>/dev/null && break; python=; \
		done; \
		[ -n "$$python" ] || { echo "error: Blender's module needs Python 3.11 or 3.13 with venv: install one of them" >&2; exit 1; }; \
		$$python -m venv target/bpy && target/bpy/bin/pip install --quiet -r tests/blender/requirements.txt && \
		cp tests/blender/requirements.txt target/bpy/; \
	}
	@target/bpy/bin/python -c 'import bpy' 2>/dev/null || \
		$(call install, libgl1 libice6 libsm6 libxfixes3 libxi6 libxkbcommon0 libxrender1 libxxf86vm1, Blender lacks libraries)

# Python with pip and venv, which Debian has in packages of their own.
pip:
	@python3 -c 'import ensurepip, pip' 2>/dev/null || $(call install, python3 python3-pip python3-venv, Python lacks pip or venv)

# A driver for the tests.
driver: toolchain
	@[ -n "$(GPU_RT_TEST_DEVICE)" ] || $(GPU_RT) devices --json 2>/dev/null | grep -q '"software": true' || \
		$(call install, libvulkan1 mesa-vulkan-drivers, no software Vulkan driver answers)

# A display that nobody sees, with a mouse, and what a window loads.
display:
	@{ command -v Xvfb && command -v xdotool && command -v weston; } >/dev/null || \
		$(call install, xvfb xdotool weston libegl1 libgl1 libgl1-mesa-dri libwayland-egl1 libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0 libxrandr2, no Xvfb with xdotool and no weston are here)

# Open Image Denoise, which the tests denoise with, unless OIDN_DIR names its folder. Python only fetches it and checks its hash.
oidn: pip
	@[ -n "$(OIDN_DIR)" ] || cmp -s tests/oidn/requirements.txt target/oidn/requirements.txt || { \
		rm -rf target/oidn && \
		PIP_ROOT_USER_ACTION=ignore python3 -m pip install --quiet --no-deps --require-hashes --target target/oidn -r tests/oidn/requirements.txt && \
		cp tests/oidn/requirements.txt target/oidn/; \
	}

# For developing: `make quick TEST=kernels ARGS=sphere`. The dev profile reads the shaders from disk: an edit of one outside shaders/data compiles nothing.
TEST ?= kernels
quick: export NODEVICE_SELECT = 1
quick: toolchain oidn
	$(CARGO) test --test $(TEST) -- $(ARGS)

# With these, only leaks make the memory of a soak grow. Otherwise it also grows when kernels no longer come from the driver's cache on disk,
# and by chance, because each thread has a heap.
test-long soak: export MESA_SHADER_CACHE_DISABLE = true
test-long soak: export MALLOC_ARENA_MAX = 1

# What takes minutes: statistics of thousands of renders, and 1e9 paths through all scenes.
test-long: export NODEVICE_SELECT = 1
test-long: toolchain
	$(CARGO) test $(BUILD) --test long --test unchanged --test program --test images --test kernels -- --ignored --nocapture

# A render over a real Slurm, with two nodes on this machine, of which one fails. About a minute, as root.
test-slurm: toolchain slurm
	$(CARGO) build $(BUILD)
	@root=; [ "$$(id -u)" = 0 ] || root=sudo; $$root tests/slurm/run.sh

slurm:
	@PATH="$$PATH:/usr/sbin"; { command -v slurmctld && command -v slurmd && command -v munged; } >/dev/null || \
		$(call install, slurm-wlm munge, Slurm is missing)

# Whether the kernels are valid WGSL by Tint, the compiler of Chrome and Dawn, which is stricter than naga. It needs no driver.
test-tint: export NODEVICE_SELECT = 1
test-tint: toolchain
	$(CARGO) build $(BUILD)
	@command -v npm >/dev/null || $(call install, nodejs npm, no Node.js runs Tint)
	tests/tint/run.sh target/release/gpu-rt

# Environment maps that people use, from npm and from Blender's module.
test-skies: export NODEVICE_SELECT = 1
test-skies: toolchain bpy driver
	$(CARGO) build $(BUILD)
	@command -v npm >/dev/null || $(call install, nodejs npm, no Node.js unpacks the packages of npm)
	tests/skies/run.sh target/release/gpu-rt target/bpy/lib/python3.*/site-packages/bpy/*/datafiles/studiolights/world

# Files as people bring them, which npm fetches (90 MB).
test-files: toolchain
	$(CARGO) build $(BUILD)
	@command -v npm >/dev/null || $(call install, nodejs npm, no npm fetches files)
	tests/files/run.sh target/release/gpu-rt

# COUNT damaged files of every format, and ten times as many scenes. SEED chooses others.
COUNT ?= 100000
SEED ?= 2
fuzz: toolchain
	GPU_RT_FUZZ_COUNT=$(COUNT) GPU_RT_FUZZ_SEED=$(SEED) $(CARGO) test $(BUILD) --test long -- --exact fuzz::many_damaged_files_are_read_or_refused --ignored --nocapture

# Random scenes from the seed FIRST on, for SECONDS after the first hundred.
SECONDS ?= 1800
FIRST ?= 1000
soak: export NODEVICE_SELECT = 1
soak: toolchain
	GPU_RT_SOAK_SECONDS=$(SECONDS) GPU_RT_SOAK_SEED=$(FIRST) $(CARGO) test $(BUILD) --test long -- --exact soak::many_random_scenes_render_without_a_fault --ignored --nocapture

# The same tests on several drivers, fetched and not installed: a second opinion on every number.
test-drivers: toolchain oidn
	tests/drivers/matrix.sh

# docs/accuracy.md with its plots and accuracy.tsv, measured here: six scenes, each within the budget. `make accuracy BUDGET=30s` is quicker and knows less.
BUDGET ?= 70s
accuracy: export NODEVICE_SELECT = 1
accuracy: toolchain oidn
	OIDN_DIR=$${OIDN_DIR:-$(CURDIR)/target/oidn/pyoidn/oidn/lib} $(CARGO) bench --features window --bench accuracy -- --budget $(BUDGET)

# Every kernel compiled for GPUs that are not here, compared with docs/dev/gpu-kernels.tsv, which GPU_RT_RENEW=1 writes anew.
gpu-compile: export NODEVICE_SELECT = 1
gpu-compile: toolchain
	@command -v spirv-val >/dev/null || $(call install, spirv-tools, spirv-val is missing)
	@[ -n "$$VK_DRIVER_FILES" ] || ls /usr/share/vulkan/icd.d/radeon_icd* >/dev/null 2>&1 || \
		$(call install, libvulkan1 mesa-vulkan-drivers, Mesa's RADV is missing)
	@settings=; [ -n "$$VK_DRIVER_FILES" ] || settings=$$(tests/drivers/matrix.sh radv) || echo "using the installed Mesa"; \
		env $$settings $(CARGO) bench --features window --bench gpu_compile

# On a machine with a GPU: the tests on it, and what it renders by which settings, within nine minutes. docs/gpu-NAME.md has it then.
# DEVICE names another device than the default.
DEVICE ?=
GPU_SECONDS ?= 540
OUT ?= docs
gpu: gpu-kit
	OUT="$(OUT)" target/gpu-kit/run.sh "$(DEVICE)" $(GPU_SECONDS)

# Which of the ways to walk through meshes is the fastest there, within six minutes: docs/walks-NAME.md.
gpu-walks: gpu-kit
	OUT="$(OUT)" target/gpu-kit/run.sh walks "$(DEVICE)"

# What that runs, for a machine without a compiler: copy the repository and this folder, and run target/gpu-kit/run.sh.
gpu-kit: toolchain
	$(CARGO) build $(BUILD)
	$(CARGO) bench --features window --no-run --bench gpu --bench walks
	rm -rf target/gpu-kit && mkdir -p target/gpu-kit
	cp target/release/gpu-rt tests/gpu/run.sh target/gpu-kit
	@echo "$(CURDIR)" >target/gpu-kit/root
	@for name in kernels images; do \
		cp "$$($(CARGO) test $(BUILD) --no-run --test $$name 2>&1 | sed -n 's/.*(\(target[^)]*\))$$/\1/p')" target/gpu-kit/$$name || exit 1; \
	done
	@for name in gpu walks; do \
		cp "$$($(CARGO) bench --features window --no-run --bench $$name 2>&1 | sed -n 's/.*(\(target[^)]*\))$$/\1/p')" target/gpu-kit/$$name || exit 1; \
	done
	cd target/gpu-kit && gzip gpu-rt kernels images gpu walks
	@bytes=$$(du -sb target/gpu-kit | cut -f1); [ "$$bytes" -lt 67108864 ] || { echo "error: target/gpu-kit has $$bytes bytes" >&2; exit 1; }

lint: toolchain
	$(CARGO) fmt --check
	$(CARGO) clippy --release --all-targets -- -D warnings
	$(CARGO) clippy $(BUILD) --all-targets -- -D warnings

toolchain:
	@command -v $(CARGO) >/dev/null || { echo "error: cargo is missing: install Rust, https://rustup.rs" >&2; exit 1; }
	@command -v cc >/dev/null || $(call install, gcc libc6-dev, no C linker)
