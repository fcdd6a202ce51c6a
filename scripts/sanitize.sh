#!/usr/bin/env bash
# Builds the engine with GCC's sanitizers and runs its tests on it: `make sanitize`.
#
#     scripts/sanitize.sh [memory] [threads] [-- arguments of pytest]
#
# memory: AddressSanitizer and UndefinedBehaviorSanitizer, on the v3 level (4 lanes, AVX2) and on the baseline level (plain
# x86-64 code); one live target runs the scalar code on both. The whole suite runs on v3, without the pages in a browser, which
# does not start so. Commands that tests start take the sanitizer over. The baseline level is of the same sources, so it runs
# those tests alone that feed it hostile arguments, and the contract. threads: ThreadSanitizer, on batches and live targets. It
# prints one line per run, with the tests and the reports; the reports' texts stay in build/sanitize.
# LEVELS="v3" runs one level alone, JOBS=1 compiles one file at a time, WORKERS=2 runs so many tests at once (1), MINUTES=240
# bounds the tests of one run. The exit status is 1 where there is a report, a failed test, or no end in time.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD/build/sanitize
python=${PYTHON:-$PWD/.venv/bin/python}
PATH=$(dirname "$python"):$PATH
levels=${LEVELS:-v3 baseline}

what=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do what+=("$1"); shift; done
[ $# -gt 0 ] && shift
[ ${#what[@]} -gt 0 ] || what=(memory threads)

memory_tests=(tests)
baseline_tests=(tests/contract tests/filters/test_untrusted.py tests/filters/test_bad_input.py tests/test_fuzz_public.py)
thread_tests=(tests/contract/test_contract_batch.py tests/filters/test_untrusted.py)

# build NAME SANITIZERS LEVEL: the package with such an engine in build/sanitize/NAME/package
build() {
  local here=$root/$1
  mkdir -p "$here"
  cmake -G Ninja -S . -B "$here/engine" -DPython_EXECUTABLE="$python" -DJINK_LEVELS="$3" -DJINK_SANITIZE="$2" -DJINK_SYMBOLS=ON \
    ${LAUNCHER:+-DCMAKE_CXX_COMPILER_LAUNCHER=$LAUNCHER} >"$here/configure.log" 2>&1 || { cat "$here/configure.log"; exit 1; }
  cmake --build "$here/engine" ${JOBS:+-j "$JOBS"} >"$here/build.log" 2>&1 || { tail -30 "$here/build.log"; exit 1; }
  rm -rf "$here/package"
  mkdir -p "$here/package"
  cp -r src/jink "$here/package/jink"
  rm -f "$here"/package/jink/_native_*.so
  cp "$here"/engine/_native_*.so "$here/package/jink/"
}

# run NAME LEVEL LIBRARY TESTS...: one line with what came of it
run() {
  local name=$1 level=$2 library=$3 here=$root/$1 status=0 began=$SECONDS
  shift 3
  rm -f "$here"/report.*
  # GCC's C++ library comes first, so that the sanitizer sees exceptions
  timeout $((60 * ${MINUTES:-240})) env LD_PRELOAD="$(g++ -print-file-name="$library") $(g++ -print-file-name=libstdc++.so.6)" PYTHONPATH="$here/package" \
    PYTHONMALLOC=malloc PYTHONDONTWRITEBYTECODE=1 OPENBLAS_NUM_THREADS=1 JINK_ISA="$level" JINK_SANITIZED="$name" \
    ASAN_OPTIONS="detect_leaks=0:allocator_may_return_null=1:detect_stack_use_after_return=1:log_path=$here/report" \
    UBSAN_OPTIONS="print_stacktrace=1:log_path=$here/report" \
    TSAN_OPTIONS="halt_on_error=0:history_size=4:log_path=$here/report" \
    $SETARCH "$python" -m pytest -p no:cacheprovider -n "${WORKERS:-0}" "$@" >"$here/tests.log" 2>&1 || status=$?
  local reports
  reports=$(cat "$here"/report.* 2>/dev/null | grep -cE 'runtime error:|ERROR: AddressSanitizer|WARNING: ThreadSanitizer' || true)
  printf '%-18s %s; reports: %s; exit status %s; %d s\n' "$name" "$(grep -E '(passed|failed|error)' "$here/tests.log" | tail -1)" "$reports" "$status" $((SECONDS - began))
  if [ "$reports" != 0 ]; then
    failures=1
    cat "$here"/report.* | grep -E 'runtime error:|ERROR: AddressSanitizer|WARNING: ThreadSanitizer' | sort | uniq -c | sort -rn | head -20
  fi
  [ "$status" = 0 ] || { failures=1; tail -15 "$here/tests.log"; }
}

# ThreadSanitizer needs memory where it expects it, which newer kernels' randomisation does not give
SETARCH=
setarch -R true 2>/dev/null && SETARCH="setarch -R"
failures=0
for one in "${what[@]}"; do
  case $one in
    memory)
      for level in $levels; do
        build "memory-$level" address,undefined,float-cast-overflow "$level"
        tests=("${memory_tests[@]}")
        [ "$level" != baseline ] || tests=("${baseline_tests[@]}")
        run "memory-$level" "$level" libasan.so "${@:-${tests[@]}}"
      done ;;
    threads)
      build threads-v3 thread v3
      run threads-v3 v3 libtsan.so "${@:-${thread_tests[@]}}" ;;
    *) echo "sanitize: expected memory or threads, got $one" >&2; exit 2 ;;
  esac
done
exit $failures
