"""What follows from the rows of the trade-off study: the cheapest settings and the errors of the families, as Markdown tables."""

import pareto
from tradeoff_matrix import YARDSTICK


def cheapest(rows, limit, groups=None):
    """The cheapest row whose sustained error is within the limit [%]."""
    chosen = [row for row in rows if groups is None or row["group"] in groups]
    return pareto.cheapest(chosen, "cpu_seconds", "sustained_percent", limit)


def advice(rows, accuracies):
    """For each accuracy [%] the cheapest of each group, and by how many times it is cheaper than the yardstick."""
    groups = list(dict.fromkeys(row["group"] for row in rows))
    groups = [YARDSTICK] + [group for group in groups if group != YARDSTICK]
    lines = ["| within | group | cheapest setting | estimator | particles | CPU s | error | sustained | times cheaper |",
             "|---|---|---|---|---|---|---|---|---|"]
    for limit in accuracies:
        yardstick = cheapest(rows, limit, {YARDSTICK})
        best = cheapest(rows, limit)
        for group in groups:
            row = cheapest(rows, limit, {group})
            if row is None:
                lines.append(f"| {limit:g} % | {group} | none | | | | | | |")
                continue
            gain = f"{float(yardstick['cpu_seconds']) / float(row['cpu_seconds']):.2g}" if yardstick else "no yardstick"
            mark = "**" if row is best else ""
            lines.append(f"| {limit:g} % | {group} | {mark}{row['name']}{mark} | {row['estimator']} | {row['particles']} | "
                         f"{float(row['cpu_seconds']):.2f} | {float(row['error_percent']):+.2f} % | "
                         f"{float(row['sustained_percent']):.2f} % | {gain} |")
    return lines


def front(rows):
    """The settings that no other beats in both cost and sustained error."""
    lines = ["| setting | estimator | particles | CPU s | error | sustained |", "|---|---|---|---|---|---|"]
    for row in pareto.front(rows, "cpu_seconds", "sustained_percent"):
        lines.append(f"| {row['name']} | {row['estimator']} | {row['particles']} | {float(row['cpu_seconds']):.3f} | "
                     f"{float(row['error_percent']):+.3f} % | {float(row['sustained_percent']):.3f} % |")
    return lines


def curves(rows):
    """The error of each family on each of its cells, by the first estimator; not of those whose mesh another key makes finer."""
    sizes = sorted({int(row["cells"]) for row in rows if row["runs"] == "1"})
    lines = ["| family | " + " | ".join(f"n = {n}" for n in sizes) + " |", "|---|" + "---|" * len(sizes)]
    for family in dict.fromkeys(row["family"] for row in rows if row["runs"] == "1"):
        members = [row for row in rows if row["family"] == family and row["estimator"] == rows[0]["estimator"]]
        own = {int(row["cells"]): row for row in members}
        if len(own) < len(members):
            continue
        cell = {n: f"{float(r['error_percent']):.2f}" if r["error_percent"] else "failed" for n, r in own.items()}
        lines.append(f"| {family} | " + " | ".join(cell.get(n, "") for n in sizes) + " |")
    return lines
