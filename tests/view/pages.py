"""What tests of pages share: the data in one."""

import json
import re


def data_of(page):
    """What the page's scripts read."""
    (text,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page.html, flags=re.S)
    return json.loads(text)
