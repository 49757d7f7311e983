"""Heads that recorders give their columns, and the channels that they are.

Sources: WITS specification, records 1 and 7 (HKLA, TQA, RPMA, SPPA, SPM1 to 3, BPOS, DBTM, MFIA, SMTF, SGTF); PWLS and
WITSML 1.4.1.1 mnemonics of operators' data sets (Volve: HKLI, TRPM_RT, BPOS, SPPA, DBTM, TFLO, STOR); heads of exports
of Pason (Hook Load, Rotary RPM, Standpipe Pressure, Convertible Torque), Totco/RigSense (HKLD, ROTARY_TORQUE, WOH,
BLOCK_POSITION) and Petrolink; German words of the rig floor, umlauts written out. The first names are the better ones
where a table has several of one channel.
"""

from __future__ import annotations

import re
import unicodedata

# Channel of `slider_drilling.table_import.mapping.IMPORT_CHANNELS` -> heads, in lower case, words apart by one blank.
HEADS: dict[str, str] = {
    "top_drive_angle": "td angle, tdangle, top drive angle, top drive position, quill position, quill angle, qpos, "
        "tdpos, rotary position, rotary angle, "
        "drehwinkel, top drive winkel",
    "top_drive_speed": "rpma, rpm, rpms, td rpm, tdrpm, trpm, trpm rt, top drive rpm, top drive speed, surface rpm, "
        "surf rpm, srpm, rotary rpm, rotary speed, rotary speed surf avg, rotation rpm, string rpm, drillstring rpm, "
        "rot rpm, rotary, quill speed, quill rpm, drpm, rpm surface avg, "
        "drehzahl, top drive drehzahl, drehtischdrehzahl, strangdrehzahl, gestaengedrehzahl",
    "surface_torque": "tqa, tq, trq, torque, stor, tor, tdtq, td torque, tdtorque, top drive torque, rotary torque, "
        "rotary torque surf avg, surface torque, surf torque, strq, tord, convertible torque, string torque, "
        "quill torque, torque abs, rt torque, tqabs, stq, torque avg, surface torque avg, "
        "drehmoment, top drive drehmoment, drehtischdrehmoment, strangdrehmoment, gestaengedrehmoment",
    "hook_load": "hkla, hkld, hkl, hkli, hkldav, hld, woh, hl, hook load, hookload, hook load avg, hookload avg, "
        "average hookload, weight on hook, total hookload, string weight, hook weight, "
        "hakenlast, hakengewicht",
    "standpipe_pressure": "sppa, spp, sppr, sppav, stand pipe pressure, standpipe pressure, standpipe pressure avg, "
        "standpipe, spressure, pump pressure, pumppressure, standpipe pressure 1, spp1, spp 1, stp, mud pressure, "
        "standrohrdruck, steigleitungsdruck, pumpendruck, spuelungsdruck, spueldruck",
    "pump_flow": "mfia, tflo, flwi, flwin, flow in, flowin, flow in rate, mud flow in, mud flow in avg, flow rate in, "
        "total pump output, pump output, total flow, total flow rate, pump flow, flow pumps, mfi, flin, gpm, "
        "flow rate, "
        "foerdermenge, foerderrate, foerderstrom, spuelungsrate, spuelrate, pumpenvolumenstrom, durchfluss",
    "pump_speed": "spm, tspm, spmt, total spm, spm total, total pump rate, pump spm total, total strokes per minute, "
        "pump rate, strokes per minute, spm tot, stroke rate, pump speed, "
        "hubzahl, hubzahl gesamt, gesamthubzahl, pumpenhubzahl, huebe pro minute, pumpendrehzahl",
    "block_position": "bpos, blkp, blkpos, block, blk pos, block position, block height, blockheight, blockpos, blkht, "
        "traveling block position, travelling block position, traveling block height, tbpos, hook position, "
        "hook height, hkht, posbk, bph, "
        "blockhoehe, blockstellung, flaschenzughoehe, hakenhoehe, hakenposition",
    "tool_face": "gtf, sgtf, tfg, gravity tool face, gravity toolface, gtfa, tool face gravity, toolface gravity, "
        "tool face, toolface, tfo, tf, tfa, tface, tf grav, mwd toolface, mwd tool face, tool face orientation, "
        "mtf, smtf, tfm, magnetic tool face, magnetic toolface, tf mag",
    "bit_depth": "dbtm, bit depth, bitdepth, depth bit, depth bit meas, bit measured depth, bdep, bdia, dept bit, "
        "bit md, bit position, dbit, bitdep, "
        "meisselteufe, meisseltiefe, bohrmeisselteufe, bohrmeisseltiefe, bitteufe, bittiefe, meisselposition",
}  # fmt: skip
# Heads of one pump among several, which are added up.
PUMP = re.compile(r"(?:spm|mp|pump|p)\s*(?:no|nr)?\s*#?\s*[1-6a-d]\s*(?:spm|stks?|strokes?|stroke rate|speed|spm avg)?|"
                  r"(?:spm|pump stroke rate|stroke rate|pump spm|strokes per minute)\s*#?\s*[1-6]|"
                  r"(?:hubzahl(?: pumpe)?|pumpe)\s*(?:nr)?\s*#?\s*[1-6]\s*(?:hubzahl|huebe)?")  # fmt: skip
# A unit that a head itself names.
IMPLIED_UNITS = {"top_drive_speed": ("rpm", re.compile(r"rpm")), "pump_flow": ("gpm", re.compile(r"^gpm$")),
                 "pump_speed": ("spm", re.compile(r"spm|stks|strokes|hubzahl|huebe"))}  # fmt: skip
MAGNETIC = ("mtf", "smtf", "tfm", "magnetic tool face", "magnetic toolface", "tf mag")
DATE_HEADS = ("date", "day", "rig date", "log date", "yyyy/mm/dd", "mm/dd/yyyy", "dd/mm/yyyy", "rtdate", "datum")
TIME_HEADS = (
    "datetime", "date time", "timestamp", "time stamp", "date and time", "date/time", "rig time", "rigtime", "time",
    "utc", "utc time", "local time", "time utc", "time of day", "t", "etim", "elapsed time", "rttime", "clock", "index",
    "time s", "unix time", "epoch", "zeit", "uhrzeit", "hh:mm:ss", "tim", "rig date time", "datum zeit",
    "datum/zeit", "datum uhrzeit", "datum/uhrzeit", "datum und uhrzeit", "zeitstempel", "messzeit",
)  # fmt: skip
_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss"})


def plain_head(head: str) -> str:
    """A head in lower case, umlauts as two letters, one blank between its words; camel case is kept together."""
    text = re.sub(r"[_\-.,;]+", " ", unicodedata.normalize("NFC", head).replace("\u00a0", " "))
    return " ".join(text.lower().translate(_UMLAUTS).split())


def rank(channel: str, head: str) -> int | None:
    """How good a head is for a channel, 0 for the best; None where it is none of its heads."""
    names = [name.strip() for name in HEADS[channel].split(",")]
    plain = plain_head(head)
    if plain in names:
        return names.index(plain)
    squeezed = plain.replace(" ", "")
    joined = [name.replace(" ", "") for name in names]
    return joined.index(squeezed) if squeezed in joined else None


def is_pump(head: str) -> bool:
    """Whether a column is the strokes of one pump among several."""
    return PUMP.fullmatch(plain_head(head)) is not None
