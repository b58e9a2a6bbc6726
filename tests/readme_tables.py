"""Put generated tables into a text: what stands between <!-- NAME --> and <!-- /NAME --> becomes the file's content.

    readme_tables.py README.md NAME=FILE...            write
    readme_tables.py --check README.md NAME=FILE...    exit 1 if it would change, touch nothing
"""
import re
import sys


def main():
    arguments = sys.argv[1:]
    check = arguments[:1] == ["--check"]
    if check:
        arguments = arguments[1:]
    if len(arguments) < 2 or not all("=" in a for a in arguments[1:]):
        sys.exit(__doc__)
    path = arguments[0]
    with open(path) as file:
        old = text = file.read()
    for argument in arguments[1:]:
        name, source = argument.split("=", 1)
        with open(source) as file:
            content = file.read().strip("\n")
        pattern = re.compile(r"(<!-- %s -->\n).*?(<!-- /%s -->)" % (re.escape(name), re.escape(name)), re.S)
        if len(pattern.findall(text)) != 1:
            sys.exit("%s: wants exactly one <!-- %s --> ... <!-- /%s -->" % (path, name, name))
        text = pattern.sub(lambda m: m.group(1) + content + "\n" + m.group(2), text)
    if text == old:
        return
    if check:
        sys.exit("%s: its tables are not those of %s" % (path, ", ".join(arguments[1:])))
    with open(path, "w") as file:
        file.write(text)


if __name__ == "__main__":
    main()
