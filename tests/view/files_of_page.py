"""What tests of files that a page makes share: press a button of "Share", and have the file."""

import base64
import re
import struct

KEEP = """
window.files = [];
const address = URL.createObjectURL;
URL.createObjectURL = (blob) => (files.push(blob), address.call(URL, blob));
HTMLAnchorElement.prototype.click = function () { files.at(-1).name = this.download; };
"""
READ = """
const [file, done] = [files.at(-1), arguments[0]];
const reader = new FileReader();
reader.onload = () => done([file.name, file.type, reader.result.split(",")[1]]);
reader.readAsDataURL(file);
"""


def file_of(browser, button):
    """Press a button of the dialog; return name, type and content of the file that it makes."""
    browser.driver.execute_script(KEEP)
    browser.click("#share")
    browser.click(button)
    browser.wait("files.length && files.at(-1).name && document.getElementById('work').hidden")
    name, kind, text = browser.driver.execute_async_script(READ)
    browser.click("#done")
    return name, kind, base64.b64decode(text)


def link_of(browser):
    """Press the button that copies the link, and return what is copied."""
    browser.driver.execute_script(
        "window.copied = null; Object.defineProperty(navigator, 'clipboard', "
        "{ value: { writeText: async (text) => (window.copied = text) } })"
    )
    browser.click("#share")
    browser.click("#copy")
    browser.wait("document.getElementById('said').textContent === 'Copied.'")
    return browser.js("copied")


def duration_of(video):
    """Return the duration, s, that a WebM file states."""
    assert video[:4] == bytes.fromhex("1a45dfa3")  # EBML
    assert bytes.fromhex("2ad7b1830f4240") in video  # times are in ms
    stated = re.search(b"\x44\x89(\x84.{4}|\x88.{8})", video, re.DOTALL)[1]
    return struct.unpack(">f" if len(stated) == 5 else ">d", stated[1:])[0] / 1e3
