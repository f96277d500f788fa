"""What tests of files that a page makes share: press a button of "Share", and have the file."""

import base64

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
