"""Typesets the formulas of the pages, which are written as plain text, as MathML.

`typeset(text)` divides a text into words and formulas. A formula is a run of symbols, numbers and operators with a sign
that prose does not have: an index, a power, a Greek letter, an accent, or a relation between symbols.
"""

import re
import unicodedata
from html import escape

ACCENTS = {"\u0303": "~", "\u0304": "\u203e", "\u0302": "^", "\u0307": "\u02d9"}
RAISED = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺ⁿᵏᵀ", "0123456789−+nkT"))
LOWERED = dict(zip("₀₁₂₃₄₅₆₇₈₉₊₋", "0123456789+−"))
FUNCTIONS = set(
    "sin cos tan sinh cosh tanh coth asin atan asinh exp expm1 ln log erf erfc max min mean Re Im det shm chm sum diag "
    "dev tr rms arg const tol limit dir".split()
)
# Symbols with an index that is written without a mark.
_INDEXED = (
    r"([KGTJML])(L|N|T|c|n|t|xx|yy|zz|xy|yx|xz|zx|yz|zy|ij|nn|nt|tn|tt|bb|tb|bt)|([qunL])([xyz])|(z)(m)|(C)(11|12|44)"
    r"|(m)([024])|([σεγ])([xyz]{2}|ij)|([φδ])([nt])|(X)([xz])|([SC])([zb])|(g)([ls])|(p)(0)|(L)(\d\d)|([bce])(\d)"
)
INDEXED = re.compile(rf"(?:{_INDEXED})$")
INSIDE = re.compile(rf"(?<![A-Za-z])(?:{_INDEXED})(?![A-Za-z])")
RELATION = "=≠≤≥<>≪≫≈∝→←⇒⇔≡∈~↔≃∥"
OPERATOR = RELATION + "+−±∓·×/:|∣⟨⟩"
GREEK = "α-ωΑ-Ω"
NUMBER = re.compile(r"\d+(?:[.,]\d+)*(?:e[-−]?\d+)?")
LETTER = rf"[A-Za-z{GREEK}ϱℓ∂∇∞ΣΠ∫]"
WORD = re.compile(r"[A-Za-z]{2,}\d?")
UNIT = re.compile(r"[(]?(?:[kMGmµnhc]?(?:Pa|m|N|J|W|K|s|S|l|g|Hz|V|A|yr|h|d|b)[²³⁻¹]*[)]?[/·*]?[(]?)+[)]?$")
STRONG = re.compile(
    rf"[{GREEK}ϱℓ√∂∇∞∫½¼¾⅓⅔†]|[A-Za-z{GREEK}ϱ\u0303\u0304\u0302\u0307)′'*][_^]|[A-Za-z)\]][⁰¹²³⁴-⁹⁻ⁿᵀ]|[A-Za-z)][₀-₉]"
    rf"|\b[A-Za-z]\*|[\u0303\u0304\u0302\u0307]|^[({{\[]*[A-Za-z]\((?:[a-z]|[a-z], ?[a-z])\)"
)
ALLOWED = re.compile(
    rf"[A-Za-z{GREEK}ϱℓ0-9_^{{}}()\[\]{re.escape(OPERATOR)}.,′’'*†½¼¾⅓⅔√∂∇∞∫⌊⌉⌈…!⁰¹²³⁴-⁹⁻⁺ⁿᵏᵀ₀-₉₊₋\u0302-\u0307‖∘|-]+$"
)


def _is_words(token: str, longest: int) -> bool:
    """True if a token has words of a language: letters side by side that are no symbol, more than `longest`."""
    bare = re.sub(r"[_^](?:\{[^}]*\}|\([^)]*\)|[A-Za-z0-9,∥*]+)", " ", token)
    bare = re.sub(rf"(?<![A-Za-z])d(?=[A-Za-z{GREEK}](?![A-Za-z]))", " ", INSIDE.sub(" ", bare))
    bare = re.sub(rf"(?<=[{GREEK}0-9])[A-Za-z]{{2,3}}(?![A-Za-z])", " ", bare)
    return any(word not in FUNCTIONS and len(word) > longest for word in WORD.findall(bare))


def _kind(token: str, longest: int) -> str:
    """Returns strong (a formula of itself), operator, letter, number, or an empty text for words."""
    if not ALLOWED.match(token) or re.search(r"[a-z]-[a-z]|\.\.", token):
        return ""
    if all(sign in OPERATOR + "()[]{}…" for sign in token):
        return "operator"
    if NUMBER.fullmatch(token.strip("()[]{}−±")):
        return "number"
    if (
        "/" in token
        and UNIT.match(token)
        or re.fullmatch("[kcmµn]?m[²³]|[0-9a-f]{7,40}", token)
        or re.fullmatch(r"[0-9.]*[⁰¹²³⁴-⁹⁻]+", token)
        or re.fullmatch(r"[-0-9.,·×⁰-⁹⁻¹²³^()]+", token)
    ):
        return ""
    if _is_words(token, longest):
        return ""
    if STRONG.search(token) or INSIDE.search(token):
        return "strong"
    if re.fullmatch(r"[({\[−±|]*[A-Za-z]['′]*[)}\]|]*", token) or INDEXED.match(token) or token in FUNCTIONS:
        return "letter"
    if re.match(rf"(?:{'|'.join(FUNCTIONS)})[({{\[|]", token):
        return "letter"
    signs = sum(sign in OPERATOR for sign in token)
    return "compound" if signs and re.search("[A-Za-z]", token) and not re.search(r"[:|<>]", token) else ""


def _pieces(text: str) -> list[str]:
    """Divides a text at blanks outside of brackets that follow a symbol."""
    return re.split(r"( +|\n|[“”])", text)


def typeset(text: str, longest: int = 1) -> list[tuple[bool, str]]:
    """Returns the parts of a text in turn, each with whether it is a formula. Letters side by side are a product of
    symbols up to the number `longest`, else a word."""
    text = unicodedata.normalize("NFD", text).replace("=\u0338", "≠")
    text = re.sub(rf"(?<![A-Za-z])([A-Za-z{GREEK}])’(?![A-Za-z])", r"\1′", text)
    parts = _pieces(text)
    marks = []
    for part in parts:
        bare = part.rstrip(",.;:")
        kind = "operator" if part == "," else _kind(bare, longest)
        marks.append((kind if part.strip() else " ", len(part) - len(bare) if part != "," else 0))
    found: list[tuple[bool, str]] = []
    start = 0

    def plain(words: str) -> None:
        if words:
            found.append((False, unicodedata.normalize("NFC", words)))

    while start < len(parts):
        if marks[start][0] in ("", " "):
            plain(parts[start])
            start += 1
            continue
        end, depth = start, 0
        while end < len(parts) and marks[end][0]:
            depth += sum((sign in "([{") - (sign in ")]}") for sign in parts[end])
            end += 1
            if marks[end - 1][1] and not (depth > 0 and parts[end - 1].endswith(",")):
                break
        while end > start and marks[end - 1][0] == " ":
            end -= 1
        run = parts[start:end]
        kinds = [mark for mark, _ in marks[start:end] if mark != " "]
        tail = run[-1][len(run[-1].rstrip(",.;:")) :]
        joined = "".join(run)[: len("".join(run)) - len(tail)]
        # An article; a number of the sentence before a bracket, or before a symbol that the sentence goes on with.
        begin = re.match(r"a (?![=≤≥<>≈∝→←+−])|[\d.]+ (?=\()", joined)
        if begin:
            plain(begin[0])
            joined, kinds = joined[begin.end() :], kinds[1:]
        after = re.search(rf"(?<=\d) (?=[{GREEK}A-Z]$)", joined) if longest == 1 else None
        if after:
            end -= 1
            joined, kinds, tail = joined[: after.start()], kinds[:-1], " "
        before, joined, behind = _peeled(joined)
        plain(before)
        if _is_formula(joined, kinds):
            found.append((True, joined))
        elif _is_balanced(joined):
            plain(joined)
        else:
            for word in _balanced_words(joined):
                sign = re.match("[−+±]?", word)[0]
                first, inner, last = _peeled(word[len(sign) :])
                plain(sign + first)
                kind = "strong" if any(_kind(part.rstrip(","), longest) == "strong" for part in inner.split()) else ""
                if kind and _is_balanced(inner):
                    found.append((True, inner))
                else:
                    plain(inner)
                plain(last)
        plain(behind + tail)
        start = end
    return found


def _balanced_words(text: str) -> list[str]:
    """Divides a text at blanks outside of brackets, and at every blank after a bracket that nothing closes."""
    words, found = re.split("( +|\n)", text), []
    while words:
        length = next((n for n in range(1, min(len(words), 15) + 1) if _is_balanced("".join(words[:n]))), 1)
        found.append("".join(words[:length]))
        words = words[length:]
    return found


def _is_balanced(text: str) -> bool:
    return all(text.count(a) == text.count(b) for a, b in ("()", "[]", "{}"))


def _peeled(text: str) -> tuple[str, str, str]:
    """Divides brackets without their fellow from both ends of a text."""
    start, end = 0, len(text)
    for opening, closing in ("()", "[]"):
        while (
            start < end and text[start] == opening and text[start:end].count(opening) > text[start:end].count(closing)
        ):
            start += 1
        while (
            start < end and text[end - 1] == closing and text[start:end].count(closing) > text[start:end].count(opening)
        ):
            end -= 1
    return text[:start], text[start:end], text[end:]


def _is_formula(joined: str, kinds: list[str]) -> bool:
    if not joined.strip() or not _is_balanced(joined):
        return False
    if "strong" in kinds:
        return True
    symbols = sum(kind in ("letter", "compound") for kind in kinds)
    related = any(sign in joined for sign in "=≤≥<>≈∝→←")
    return bool(symbols and len(kinds) >= 3 and related)


class _Reader:
    """Reads a formula and writes MathML."""

    def __init__(self, text: str) -> None:
        self.text, self.place = text, 0

    def more(self) -> bool:
        return self.place < len(self.text)

    def row(self, until: str = "") -> str:
        found, depth = "", 0
        opening = {")": "(", "}": "{"}.get(until, "")
        while self.more():
            sign = self.text[self.place]
            if until and sign == until and not depth:
                break
            depth += (sign == opening) - (sign == until) if until else 0
            found += self.scripted()
        return found

    def scripted(self) -> str:
        base = self.atom()
        low, high = "", ""
        while self.more():
            sign = self.text[self.place]
            if sign == "_":
                self.place += 1
                low += self.script()
            elif sign == "^":
                self.place += 1
                high += self.script()
            elif sign in RAISED:
                high += self.run(RAISED)
            elif sign in LOWERED:
                low += self.run(LOWERED)
            elif sign in "*†′’'" and "<mo" not in base[:3]:
                self.place += 1
                high += f"<mo>{ {'*': '∗', chr(39): '′', '’': '′'}.get(sign, sign) }</mo>"
            else:
                break
        if low and high:
            return f"<msubsup>{base}<mrow>{low}</mrow><mrow>{high}</mrow></msubsup>"
        if low:
            return f"<msub>{base}<mrow>{low}</mrow></msub>"
        return f"<msup>{base}<mrow>{high}</mrow></msup>" if high else base

    def run(self, table: dict[str, str]) -> str:
        word = ""
        while self.more() and self.text[self.place] in table:
            word += table[self.text[self.place]]
            self.place += 1
        return _Reader(word).row()

    def script(self) -> str:
        for opening, closing in (("{", "}"), ("(", ")")):
            if self.text.startswith(opening, self.place):
                self.place += 1
                inside = self.row(closing)
                self.place += 1
                return inside
        match = re.compile(rf"[−+]?[{GREEK}∞∥*]|[−+]?[A-Za-z]+[0-9]*|[−+]?[0-9.]+").match(self.text, self.place)
        if not match:
            return ""
        self.place = match.end()
        word = match[0]
        if re.fullmatch("[A-Za-z]{2,}", word) and not re.fullmatch("[xyzij]{2,3}", word):
            return f"<mtext>{word}</mtext>"
        return _Reader(word).row()

    def atom(self) -> str:
        text, place = self.text, self.place
        sign = text[place]
        if sign in " \n":
            self.place += 1
            side = place and re.match(r"[\w)\]},²³′*]", text[place - 1])
            return '<mspace width="0.17em"/>' if side and re.match(r"[\w(\[{√½¼∂]", text[place + 1 :]) else ""
        if match := NUMBER.match(text, place):
            self.place = match.end()
            return f"<mn>{match[0]}</mn>"
        if sign == "√":
            self.place += 1
            if text.startswith("(", self.place):
                self.place += 1
                inside = self.row(")")
                self.place += 1
            else:
                inside = self.scripted() if self.more() else ""
            return f"<msqrt>{inside}</msqrt>"
        if match := re.compile("[A-Za-z]{2,}[0-9]?").match(text, place):
            return self.word(match[0])
        if match := re.compile(rf"([{GREEK}]|[A-Za-z][0-9]?)([xyzij]{{2}}|[nt0-9]{{1,2}}|)(?![A-Za-z])").match(
            text, place
        ):
            if (index := INDEXED.match(match[0])) and match[2] or (index := INDEXED.match(match[0])):
                self.place = match.end()
                base, low = (group for group in index.groups() if group)
                return f"<msub><mi>{base}</mi>{_Reader(low).row()}</msub>"
        self.place += 1
        if re.match(LETTER, sign):
            if self.more() and text[self.place] in ACCENTS:
                accent = ACCENTS[text[self.place]]
                self.place += 1
                return f'<mover accent="true"><mi>{sign}</mi><mo stretchy="false">{accent}</mo></mover>'
            if sign in "ΣΠ∫∂∇":
                return f"<mo>{ {'Σ': '∑', 'Π': '∏'}.get(sign, sign) }</mo>"
            return f"<mi>{sign}</mi>"
        if sign in "½¼¾⅓⅔":
            upper, lower = {"½": "12", "¼": "14", "¾": "34", "⅓": "13", "⅔": "23"}[sign]
            return f"<mfrac><mn>{upper}</mn><mn>{lower}</mn></mfrac>"
        if sign in "*†":
            return f"<mo>{sign}</mo>"
        if sign == "/":
            return '<mo lspace="0" rspace="0">/</mo>'
        stretchy = ' stretchy="false"' if sign in "()[]{}|∣⟨⟩⌊⌋⌈⌉‖" else ""
        return f"<mo{stretchy}>{escape(sign)}</mo>"

    def word(self, word: str) -> str:
        """A function, a symbol with an index, or a product of letters."""
        if word in FUNCTIONS:
            self.place += len(word)
            return f"<mi>{word}</mi><mo>&#x2061;</mo>"
        if match := INDEXED.match(word):
            self.place += len(word)
            base, low = (group for group in match.groups() if group)
            low = _Reader(low).row() if len(low) < 3 else f"<mtext>{low}</mtext>"
            return f"<msub><mi>{base}</mi><mrow>{low}</mrow></msub>"
        for length in (6, 5, 4, 3, 2):
            if word[:length] in FUNCTIONS:
                self.place += length
                return f"<mi>{word[:length]}</mi><mo>&#x2061;</mo>"
        self.place += 1
        return f"<mi>{word[0]}</mi>"


def _breakable(formula: str) -> list[str]:
    """Divides a formula before relations and sums outside of brackets, where a line may end."""
    found, depth, start = [], 0, 0
    for place, sign in enumerate(formula):
        depth += (sign in "([{") - (sign in ")]}")
        ends = sign in "=≤≥≈∝→←⇒⇔<>" or (sign in "+−" and place - start > 24)
        if depth == 0 and ends and place and formula[place - 1] == " " and formula[start:place].strip():
            found.append(formula[start:place].rstrip())
            start = place
    return [*found, formula[start:]]


def mathml(formula: str) -> str:
    """Returns a formula as MathML, in pieces between which a line may end."""
    formula = unicodedata.normalize("NFD", formula).replace("=\u0338", "≠")
    rows = [_Reader(piece).row() for piece in _breakable(formula)]
    infix = '<mo form="infix" lspace="0" rspace="0.25em">'
    rows = [re.sub("^<mo>", infix, row) if number else row for number, row in enumerate(rows)]
    return '<span class="math">' + " ".join(f"<math><mrow>{row}</mrow></math>" for row in rows) + "</span>"
