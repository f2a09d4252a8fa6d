"""Times JSON Schema validators on the documents that the bench `validate` writes, for the ratios of
docs/reference/performance-labels.md. Not part of the build: ajv and jsonschema are other people's programs.

    WHYROAD_BENCH_DOCUMENTS=/tmp/docs cargo bench -p whyroad-label --bench validate
    npm install --prefix /tmp/docs ajv ajv-formats && pip install jsonschema
    python3 crates/whyroad-label/benches/peers.py /tmp/docs schema/coc_output_schema.json

Both are given the schema once. ajv compiles it, checks formats and reports all errors, as `whyroad validate` does;
reading and parsing the lines is timed too, because a check of a file includes it.
"""

import json
import subprocess
import sys
import time
from pathlib import Path

AJV = """
const fs = require("fs");
const Ajv = require("ajv/dist/2020").default ?? require("ajv/dist/2020");
const formats = require("ajv-formats").default ?? require("ajv-formats");
const [schema, file] = process.argv.slice(2);
const ajv = new Ajv({ allErrors: true, strict: false });
formats(ajv);
const validate = ajv.compile(JSON.parse(fs.readFileSync(schema, "utf8")));
const lines = fs.readFileSync(file, "utf8").split("\\n");
let best = Infinity, wrong = 0;
for (let round = 0; round < 5; round++) {
  const start = process.hrtime.bigint();
  wrong = 0;
  for (const line of lines) if (!validate(JSON.parse(line))) wrong++;
  best = Math.min(best, Number(process.hrtime.bigint() - start) / 1e9);
}
console.log(JSON.stringify({ seconds: best, documents: lines.length, wrong }));
"""

# jsonschema is slow enough that a part of the documents tells.
PYTHON_DOCUMENTS = 2000


def ajv(folder: Path, schema: Path, file: Path) -> str:
    script = folder / "ajv_bench.cjs"
    script.write_text(AJV)
    run = subprocess.run(["node", script, schema.resolve(), file], capture_output=True, text=True, cwd=folder)
    if run.returncode != 0:
        return f"ajv: not measured ({run.stderr.strip().splitlines()[-1:]})"
    out = json.loads(run.stdout)
    return f"ajv with formats: {out['seconds'] / out['documents'] * 1e6:.2f} us each, {out['wrong']} wrong"


def python(schema: Path, file: Path) -> str:
    import jsonschema

    lines = file.read_text(encoding="utf-8").splitlines()[:PYTHON_DOCUMENTS]
    validator = jsonschema.Draft202012Validator(
        json.loads(schema.read_text(encoding="utf-8")), format_checker=jsonschema.FormatChecker()
    )
    start = time.perf_counter()
    wrong = sum(any(True for _ in validator.iter_errors(json.loads(line))) for line in lines)
    each = (time.perf_counter() - start) / len(lines)
    return f"python jsonschema: {each * 1e6:.2f} us each, {wrong} wrong of {len(lines)}"


def main() -> None:
    folder, schema = Path(sys.argv[1]), Path(sys.argv[2])
    for file in sorted(folder.glob("*.jsonl")):
        print(file.name)
        print(" ", ajv(folder, schema, file))
        print(" ", python(schema, file))


if __name__ == "__main__":
    main()
