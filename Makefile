# make check runs all that must be clean before a change lands.
.PHONY: check format lint types tests short slow docs benchmarks interop data-interop soak

check: lint types tests slow docs

format:
	ruff format .
	ruff check --fix .

lint:
	ruff format --check .
	ruff check .

types:
	mypy
	cd tests/typing && mypy uses.py # as users do: from elsewhere, with what is installed

tests:
	pytest -n 3 --dist worksteal

short: # what depends most on the version of Python, in about three minutes; it needs only [test]
	pytest -n 2 --dist worksteal tests/test_errors.py tests/test_files.py tests/test_geometry.py \
		tests/description tests/schema tests/env/test_env_determinism.py tests/env/test_env_rewards.py \
		tests/rollout/test_record.py tests/rollout/test_players.py
	taskbuilder validate handover --quick

slow:
	pytest -n 3 --dist worksteal --runslow -m slow

docs:
	cd docs && python -m generators # writes anew what pages show of the library
	sphinx-build -q -W -b html docs docs/_build/html

benchmarks:
	python benchmarks/authoring.py
	python benchmarks/watching.py --out benchmarks/results/watching.json
	python benchmarks/reloading.py --out benchmarks/results/reloading.json
	python benchmarks/physics_hz.py
	python benchmarks/environments.py
	python benchmarks/experts.py

interop:
	tests/interop/run.sh
	tests/interop/benchmarl.sh

data-interop:
	tests/data_interop/run.sh

soak:
	python benchmarks/soak.py
	python benchmarks/kills.py
