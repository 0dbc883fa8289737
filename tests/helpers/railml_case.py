"""Small railML files, made by hand: lines and rolling stock of each version that is read."""

from tests.helpers.railml_line_case import LINE_2, LINE_3
from tests.helpers.railml_stock_case import STOCK_2, STOCK_3, STOCK_32, STOCK_33

SAMPLES = {
    "line_2": LINE_2,
    "stock_2": STOCK_2,
    "line_3": LINE_3,
    "stock_3": STOCK_3,
    "stock_32": STOCK_32,
    "stock_33": STOCK_33,
}
