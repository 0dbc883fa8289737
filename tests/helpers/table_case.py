"""Tables as files, and what reading them is refused with."""

import io

import pytest

TRAIN_WITH_TABLE = """[train]
mass_t = 200
max_speed_kmh = 120
davis_a_n = 2000
davis_b_n_per_kmh = 10
davis_c_n_per_kmh2 = 0.5
friction_brake_kn = 150
traction = { file = "effort.csv" }
"""
EFFORT_TABLE = "Speed [km/h];Effort [kN]\n0;200\n36;200\n36;150\n72,0;100,5\n"


def workbook(**content):
    """Bytes of a workbook of sheets, each a list of rows."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in content.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    data = io.BytesIO()
    book.save(data)
    return data.getvalue()
