// node in_node.mjs PYODIDE SOURCES SITE: which modules of springpot Python in a browser imports, what
// the others lack, and what the command's help says. There are no numpy, threads and processes.

import { pathToFileURL } from "node:url";

const [, , pyodide, sources, site] = process.argv;
const { loadPyodide } = await import(pathToFileURL(`${pyodide}/pyodide.mjs`).href);
const printed = [];
const python = await loadPyodide({ stdout: (line) => printed.push(line) });
python.mountNodeFS("/sources", sources);
for (const name of ["pluggy", "click", "rich", "pygments", "markdown_it", "mdurl"]) {
  python.mountNodeFS(`/site/${name}`, `${site}/${name}`);
}
const told = await python.runPythonAsync(`
import importlib, json, pkgutil, sys

sys.path[:0] = ["/sources", "/site"]
import springpot

lacks = {}
for found in pkgutil.walk_packages(springpot.__path__, "springpot.", onerror=str):
    if found.name.endswith("__main__"):
        continue
    try:
        importlib.import_module(found.name)
        lacks[found.name] = None
    except ModuleNotFoundError as error:
        lacks[found.name] = error.name
    except Exception as error:
        lacks[found.name] = repr(error)
from springpot.cli.group import run

try:
    run(["--help"])
except SystemExit:
    pass
json.dumps(lacks)
`);
console.log(JSON.stringify({ lacks: JSON.parse(told), help: printed.join("\n") }));
