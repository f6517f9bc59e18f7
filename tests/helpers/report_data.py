"""A reader of pages: cells of tables, addresses, tags, data and text."""

import json
from html.parser import HTMLParser


class Page(HTMLParser):
    """Cells of the tables by id, addresses, tags, data and text of a page."""

    def __init__(self, text):
        super().__init__()
        self.tables, self.addresses, self.tags, self.text = {}, [], set(), ""
        self.data, self._script = {}, None
        self._rows, self._in_cell = [], False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        """Begin a table, row or cell."""
        attributes = dict(attributes)
        self.tags.add(tag)
        self.addresses += [attributes[k] for k in ("src", "href", "srcset") if k in attributes]
        if tag == "script":
            self._script = attributes
        elif tag == "table":
            self._rows = self.tables.setdefault(attributes["id"], [])
        elif tag == "tr":
            self._rows.append([])
        elif tag in ("td", "th"):
            self._rows[-1].append("")
            self._in_cell = True

    def handle_endtag(self, tag):
        """End a cell or script."""
        if tag == "script":
            self._script = None
        if tag in ("td", "th"):
            self._in_cell = False

    def handle_data(self, text):
        """Add text to the cell it stands in; that of a script is data, or none."""
        if self._script is not None:
            if self._script.get("type") == "application/json":
                self.data[self._script["id"]] = json.loads(text)
            return
        self.text += text
        if self._in_cell:
            self._rows[-1][-1] += text
