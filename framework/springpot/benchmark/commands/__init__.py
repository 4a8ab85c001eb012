"""Commands of the race."""

COMMANDS = {
    "demo": (
        "springpot.benchmark.commands.demo",
        "The whole story on embedded data, in under a minute.",
    ),
    "run": ("springpot.benchmark.commands.run", "Run a study, or resume it, and write its tables."),
    "tables": ("springpot.benchmark.commands.tables", "Tables of a study that has been run."),
    "export": (
        "springpot.benchmark.commands.export",
        "A study's results for IOHanalyzer, COCO, CSV or Parquet.",
    ),
    "archive": (
        "springpot.benchmark.commands.archive",
        "A study's trials as one file that other studies read as rivals.",
    ),
    "regression": (
        "springpot.benchmark.commands.regression",
        "The accuracy gate for continuous integration.",
    ),
}
