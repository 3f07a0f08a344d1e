"""What follows from the rows of the trade-off study: the cheapest settings and the errors of the families, as tables whose first row is the head.

The whole tables of all studies are CSV files beside docs/evidence/tradeoff.md; the page has the rows that matter.
"""

import csv

import pareto
from tradeoff_matrix import YARDSTICK

SHOWN = "0.5"  # the accuracy [%] of which the cheapest of each group are printed
ADVICE = ["within_percent", "group", "setting", "estimator", "particles", "cpu_seconds", "error_percent", "sustained_percent", "times_cheaper", "cheapest"]
FRONT = ["setting", "estimator", "particles", "cpu_seconds", "error_percent", "sustained_percent"]


def cheapest(rows, limit, groups=None):
    """The cheapest row whose sustained error is within the limit [%]."""
    chosen = [row for row in rows if groups is None or row["group"] in groups]
    return pareto.cheapest(chosen, "cpu_seconds", "sustained_percent", limit)


def advice(rows, accuracies):
    """For each accuracy [%] the cheapest of each group, by how many times it is cheaper than the yardstick, and which is the cheapest of all."""
    groups = list(dict.fromkeys(row["group"] for row in rows))
    groups = [YARDSTICK] + [group for group in groups if group != YARDSTICK]
    table = [ADVICE]
    for limit in accuracies:
        yardstick = cheapest(rows, limit, {YARDSTICK})
        best = cheapest(rows, limit)
        for group in groups:
            row = cheapest(rows, limit, {group})
            if row is None:
                table.append([f"{limit:g}", group, *[""] * (len(ADVICE) - 2)])
                continue
            gain = f"{float('%.2g' % (float(yardstick['cpu_seconds']) / float(row['cpu_seconds']))):g}" if yardstick else ""
            table.append([f"{limit:g}", group, row["name"], row["estimator"], row["particles"], f"{float('%.2g' % float(row['cpu_seconds'])):g}",
                          f"{float(row['error_percent']):+.2f}", f"{float(row['sustained_percent']):.2f}", gain, "yes" if row is best else ""])
    return table


def front(rows):
    """The settings that no other beats in both cost and sustained error."""
    return [FRONT] + [[row["name"], row["estimator"], row["particles"], f"{float(row['cpu_seconds']):.3f}", f"{float(row['error_percent']):+.3f}",
                       f"{float(row['sustained_percent']):.3f}"] for row in pareto.front(rows, "cpu_seconds", "sustained_percent")]


def curves(rows):
    """The error of each family on each of its cells, by the first estimator; not of those whose mesh another key makes finer."""
    sizes = sorted({int(row["cells"]) for row in rows if row["runs"] == "1"})
    table = [["family", *(f"n = {n}" for n in sizes)]]
    for family in dict.fromkeys(row["family"] for row in rows if row["runs"] == "1"):
        members = [row for row in rows if row["family"] == family and row["estimator"] == rows[0]["estimator"]]
        own = {int(row["cells"]): row for row in members}
        if len(own) < len(members):
            continue
        cell = {n: f"{float(r['error_percent']):.2f}" if r["error_percent"] else "failed" for n, r in own.items()}
        table.append([family, *(cell.get(n, "") for n in sizes)])
    return table


def answer(tables):
    """The first table of the page, as Markdown: of each study (name -> table of advice) and accuracy the cheapest setting of all."""
    lines = ["| study | within | cheapest setting | particles | CPU s | times cheaper |", "|---|---|---|---|---|---|"]
    for study, table in tables.items():
        for row in (dict(zip(table[0], row)) for row in table[1:]):
            if row["cheapest"]:
                lines.append(f"| {study} | {row['within_percent']} % | {row['setting']} | {row['particles']} | {row['cpu_seconds']} | "
                             f"{row['times_cheaper'] or '–'} |")
    return lines


def groups(table):
    """Of one study, as Markdown: the cheapest of each group within SHOWN percent."""
    lines = ["| group | cheapest setting | particles | CPU s | sustained error | times cheaper |", "|---|---|---|---|---|---|"]
    for row in (dict(zip(table[0], row)) for row in table[1:]):
        if row["within_percent"] == SHOWN and row["setting"]:
            mark = "**" if row["cheapest"] else ""
            lines.append(f"| {row['group']} | {mark}{row['setting']}{mark} | {row['particles']} | {row['cpu_seconds']} | {row['sustained_percent']} % | "
                         f"{row['times_cheaper'] or '–'} |")
    none = [row[1] for row in table[1:] if row[0] == SHOWN and not row[2]]
    return lines + [f"| {'; '.join(none)} | none | | | | |"] * bool(none)


def written(tables, page, folder, rewrite):
    """Write the tables of studies, name -> (advice, front, curves), into CSV files; return the page with its table of answers."""
    heads = {"advice": ADVICE, "front": FRONT}
    for k, kind in enumerate(("advice", "front")):
        with open(folder / f"tradeoff_{kind}.csv", "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["study", *heads[kind]])
            writer.writerows([study, *row] for study, parts in tables.items() for row in parts[k][1:])
    with open(folder / "tradeoff_families.csv", "w", newline="") as file:
        sizes = sorted({n for parts in tables.values() for n in parts[2][0][1:]}, key=lambda n: int(n.split()[-1]))
        writer = csv.DictWriter(file, ["study", "family", *sizes], lineterminator="\n")
        writer.writeheader()
        writer.writerows({"study": study, **dict(zip(parts[2][0], row))} for study, parts in tables.items() for row in parts[2][1:])
    return rewrite("answer", answer({study: parts[0] for study, parts in tables.items()}), page)
