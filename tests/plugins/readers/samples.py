"""Small files of every layout, made of one Maxwell element.

So that each test knows what must be read.
"""

import io
import json

import numpy as np

OMEGA = np.array([0.1, 0.5, 2.0, 10.0, 60.0])
STIFFNESS = 1000.0 * 1j * OMEGA * 0.5 / (1 + 1j * OMEGA * 0.5)
TEMPERATURE = 25.0
STRAIN = 0.5


def number(value, decimal="."):
    return f"{value:.12g}".replace(".", decimal)


def rows(columns, separator=",", decimal="."):
    return "\n".join(
        separator.join(number(v, decimal) for v in row) for row in zip(*columns, strict=True)
    )


def moduli(separator=",", decimal=".", omega=OMEGA, scale=1.0):
    return rows((omega, STIFFNESS.real * scale, STIFFNESS.imag * scale), separator, decimal)


def table(header, separator=",", decimal=".", omega=OMEGA, scale=1.0):
    return f"{header}\n{moduli(separator, decimal, omega, scale)}\n"


def rheocompass_short():
    head = "Test:\ta gel(0,3%), x\r\nResult:\tFrequency sweep 10C\r\nInterval:\t1\r\n"
    names = "Angular Frequency\tStorage Modulus\tLoss Modulus\r\n\t\t\r\n[rad/s]\t[Pa]\t[Pa]\r\n"
    return ("\ufeff" + head + names + moduli("\t", ",").replace("\n", "\r\n") + "\r\n\r\n").encode(
        "utf-16-le"
    )


WORDS = {
    "en": (
        "Project",
        "Test",
        "Result",
        "Interval and data points",
        "Interval data",
        "Point No.",
        "Time",
        "Angular Frequency",
        "Storage Modulus",
        "Loss Modulus",
        "Shear Strain",
        "Temperature",
        "invalid",
    ),
    "fr": (
        "Projet",
        "Essai",
        "Résultat",
        "Intervalle et points de données",
        "Interval données",
        "Point No.",
        "Temps",
        "Fréquence angulaire",
        "Module de Stockage",
        "Module de Perte",
        "Déformation de Cisaillement",
        "Température",
        "invalide",
    ),
    "de": (
        "Projekt",
        "Versuch",
        "Ergebnis",
        "Intervall und Datenpunkte",
        "Intervalldaten",
        "Messpunkt",
        "Zeit",
        "Kreisfrequenz",
        "Speichermodul",
        "Verlustmodul",
        "Scherdeformation",
        "Temperatur",
        "ungültig",
    ),
    "es": (
        "Proyecto",
        "Prueba",
        "Resultado",
        "Intervalo y puntos de datos",
        "Datos del intervalo",
        "Punto",
        "Tiempo",
        "Frecuencia angular",
        "Módulo de almacenamiento",
        "Módulo de pérdida",
        "Deformación de cizalla",
        "Temperatura",
        "inválido",
    ),
    "it": (
        "Progetto",
        "Prova",
        "Risultato",
        "Intervallo e punti dati",
        "Dati intervallo",
        "Punto",
        "Tempo",
        "Frequenza angolare",
        "Modulo di conservazione",
        "Modulo di perdita",
        "Deformazione di taglio",
        "Temperatura",
        "non valido",
    ),
}


def rheocompass_full(language="en", separator="\t", decimal=","):
    """Two intervals, the second with a point that the instrument calls invalid."""
    w = WORDS[language]
    lines = [(f"{w[0]}:", "gels"), (f"{w[1]}:", "sweep"), ("",), (f"{w[2]}:", "FS 1"), ("",)]
    for interval in (1, 2):
        lines += [(f"{w[3]}:", str(interval), str(len(OMEGA)), "")]
        lines += [(f"{w[4]}:", w[5], w[6], w[7], w[8], w[9], w[10], w[11], "Status")]
        lines += [("",) * 9, ("", "", "[s]", "[rad/s]", "[Pa]", "[Pa]", "[%]", "[°C]", "")]
        for i, (w_, g) in enumerate(zip(OMEGA, STIFFNESS, strict=True), 1):
            mark = f"{i} ({w[12]})" if interval == 2 and i == 1 else str(i)
            values = (10.0 * i, w_, g.real, g.imag, STRAIN, TEMPERATURE)
            lines += [("", mark, *(number(v, decimal) for v in values), "Dy_auto")]
        lines += [("",)]
    text = "\r\n".join(separator.join(cells) for cells in lines)
    return ("\ufeff" + text).encode("utf-16-le")


def rheoplus(decimal=","):
    """Older software: quoted cells, latin-1, German."""
    lines = ['"Datenreihen-Informationen"', '"Name:","","","Gel FS"', '"Probe:","","","Gel"', '""']
    lines += ['"Messpkt.","Kreisfrequenz","Speichermodul","Verlustmodul","Temperatur","Status"']
    lines += ['"","[1/s]","[Pa]","[Pa]","[°C]","[]"']
    for i, (w, g) in enumerate(zip(OMEGA, STIFFNESS, strict=True), 1):
        cells = [str(i), *(number(v, decimal) for v in (w, g.real, g.imag, TEMPERATURE)), "Dy_auto"]
        lines.append(",".join(f'"{cell}"' for cell in cells))
    return "\r\n".join(lines).encode("latin-1")


TRIOS_HEAD = """Filename,a gel
Instrument name,5343
Operator,somebody
rundate,02/04/2026
Geometry name,40mm plate
Procedure name,Peak hold
,Amplitude sweep
proceduresegments,Peak hold#Amplitude sweep
[File Parameters]
Instrument type,Discovery HR30
Trios version,5.7
[Geometry Parameters]
Geometry Type,Parallel plate
Diameter,40.0 mm
Gap,1000 µm
Notes,compression set of 3 %
[Geometry Extended Parameters]
Compliance,1.0 mrad/N.m
Geometry Inertia,7.5 µN.m.s²
Friction,0.3 µN.m/(rad/s)
Stress constant,80000 Pa/N.m
Strain constant,20.0 1/rad
[Inertia Options]
Instrument inertia,22.5 µN.m.s²
"""


def trios(separator=","):
    columns = (STIFFNESS.real, STIFFNESS.imag, OMEGA, 0 * OMEGA + TEMPERATURE, 0 * OMEGA + STRAIN)
    names = (
        "Storage modulus,Loss modulus,Angular frequency,Temperature,"
        "Oscillation strain\nPa,Pa,rad/s,°C,%\n"
    )
    hold = (
        "[step]\nPeak hold - 1\n"
        "Stress,Shear rate,Step time,Temperature\nPa,1/s,min,°C\n1.0,2.0,3.0,25.0\n"
    )
    steps = hold + "1.5,2.0,3.5,25.0\n[step]\nFrequency sweep - 2\n" + names + rows(columns) + "\n"
    return (TRIOS_HEAD + steps).replace(",", separator).encode("utf-8-sig")


def trios_lims():
    head = (
        "[Version]\nTA Instruments LIMS export format version\t0\n[Header]\n"
        "Instrument name\tARES\n[Geometry]\n"
    )
    head += "[Geometry: Extended]\nUpper Compliance\t0.5 mrad/N.m\nLower Compliance\t0.5 mrad/N.m\n"
    head += (
        "Geometry Inertia\t5 µN.m.s²\nStress constant\t80000 Pa/N.m\nStrain constant\t20.0 1/rad\n"
    )
    steps = ""
    for temperature in (20.0, 30.0):
        steps += (
            f"[Step]\nStep name\tFrequency sweep ({temperature} °C)\n"
            f"Number of points\t{len(OMEGA)}\n"
        )
        steps += (
            "Variables\tRun time\tTemperature\tAngular frequency\t"
            "Oscillation strain (cmd)\tOscillation strain\t"
        )
        steps += (
            "Status bits\tFrequency\tTan(delta)\tComplex modulus\tG*/sin(delta)\t"
            "Storage modulus\tLoss modulus\n"
        )
        steps += "Units\ts\t°C\trad/s\t%\t%\t\tHz\t\tPa\tkPa\tPa\tPa\n"
        for w, g in zip(OMEGA, STIFFNESS, strict=True):
            cells = [
                1.0,
                temperature,
                w,
                9.0,
                STRAIN,
                "0xB5",
                w / 6.283185307179586,
                g.imag / g.real,
                abs(g),
                1.0,
            ]
            steps += "Data point\t" + "\t".join(map(str, [*cells, g.real, g.imag])) + "\n"
    return (head + steps).encode("utf-8-sig")


def trios_json(official=True):
    names = (
        ("Angular frequency", "rad/s"),
        ("Storage modulus", "Pa"),
        ("Loss modulus", "Pa"),
        ("Temperature", "°C"),
    )
    columns = (OMEGA, STIFFNESS.real, STIFFNESS.imag, 0 * OMEGA + TEMPERATURE)
    if not official:
        data = {
            "columns": [{"name": name, "unit": unit, "type": "number"} for name, unit in names],
            "values": [list(map(float, row)) for row in zip(*columns, strict=True)],
        }
        results = [{"Properties": {"Name": "sweep", "Step": 1}, "DataSet": [{"Data": data}]}]
        return json.dumps(
            {"Experiment": {"Properties": {}, "Sample": {"Name": "gel"}, "Results": results}}
        ).encode()
    headers = {
        f"{n}_{u}": {"DisplayName": n, "ValueType": "Number", "Unit": {"Name": u}} for n, u in names
    }
    headers["Results Step Id"] = {
        "DisplayName": "Results Step Id",
        "ValueType": "Uuid",
        "Unit": None,
    }
    found = []
    for step in ("a", "b"):
        for row in zip(*columns, strict=True):
            found.append(dict(zip(headers, [*map(float, row), step], strict=True)))
    inertia = {"Value": 20.5, "Unit": {"Name": "µN.m.s²"}}
    procedure = {
        "Name": "sweeps",
        "Steps": [{"Id": "a", "Name": "first sweep"}, {"Id": "b", "Name": "second sweep"}],
        "Configuration": {
            "InstrumentConfigurations": [{"InertiaOptions": {"InstrumentInertia": inertia}}]
        },
    }
    schema = {"Url": "https://software.tainstruments.com/schemas/TRIOSJSONExportSchema"}
    results = {"Processed": {"ColumnHeaders": headers, "Rows": found}}
    return json.dumps(
        {"Schema": schema, "Sample": {"Name": "gel"}, "Procedure": procedure, "Results": results}
    ).encode()


def malvern():
    names = (
        "Action Name;Time (sequence)(s);Time (action)(s);Shear stress(Pa);Shear rate(s-¹);"
        "Complex shear strain(%);"
    )
    names += (
        "Frequency(Hz);Shear modulus (elastic component)(Pa);Shear modulus (viscous component)(Pa);"
    )
    names += "Shear modulus (complex component)(Pa);Temperature(°C);Gap(mm)\n"
    lines = [f"Pre Shear;{i},5;{i},0;5,3E+001;50,0;;;;;;25,00;1,000" for i in range(1, 4)]
    for i, (w, g) in enumerate(zip(OMEGA, STIFFNESS, strict=True)):
        values = (100.0 + i, i + 1.0, w / (2 * np.pi), g.real, g.imag, abs(g))
        t, a, f, e, v, c = (number(x, ",") for x in values)
        lines.append(f"Frequency Table;{t};{a};;;0,5;{f};{e};{v};{c};25,00;1,000")
    return (names + "\n".join(lines) + "\n").encode()


def reptate(units=False):
    head = "Mw=23.4;T=-35;chem=PI;origin=Leeds;\r\n"
    names = "Freq\t G'\t G\"\r\nrad/s\t Pa\t Pa\r\n" if units else "w G' G''\r\n"
    return (head + names + moduli("\t").replace("\n", "\r\n") + "\r\n").encode("latin-1")


TIME = np.linspace(0.0, 30.0, 1500)
MOVED = np.cos(2 * TIME)
PULLED = 3 * np.cos(2 * TIME + 0.5)


def laos(comment="#Time(s)\tStrain(-)\ttau_yx(Pa)"):
    head = f"omega=2.0;gamma=1.0;\n{comment}\n" if comment else "omega=2.0;gamma=1.0;\n"
    return (head + rows((TIME, MOVED, PULLED), "\t") + "\n").encode()


def mat(compressed=True, **arrays):
    from scipy.io import savemat

    stream = io.BytesIO()
    savemat(
        stream,
        arrays or {"t_s": TIME, "disp_mm": MOVED, "force_kN": PULLED},
        do_compression=compressed,
    )
    return stream.getvalue()


def tdms(units=True, clock=False):
    from nptdms import ChannelObject, TdmsWriter

    def channel(name, values, unit):
        properties = {"unit_string": unit} if units and unit else {}
        if clock:
            properties |= {"wf_increment": TIME[1] - TIME[0]}
        return ChannelObject("run", name, values, properties=properties)

    stream = io.BytesIO()
    with TdmsWriter(stream) as writer:
        channels = [channel("Displacement", MOVED, "mm"), channel("Force", PULLED, "kN")]
        writer.write_segment(channels if clock else [channel("Time", TIME, "s"), *channels])
    return stream.getvalue()


def xlsx(sheets=None):
    """By default as ViscoAnalysis takes it: T °C, f Hz, |E*| MPa, phi deg."""
    from openpyxl import Workbook

    book = Workbook()
    book.remove(book.active)
    if sheets is None:
        cells = [
            [
                TEMPERATURE,
                float(w / (2 * np.pi)),
                float(abs(g)) / 1e6,
                float(np.degrees(np.angle(g))),
            ]
            for w, g in zip(OMEGA, STIFFNESS, strict=True)
        ]
        sheets = {"Data": [["T °C", "f Hz", "|E*| MPa", "φ deg"], *cells]}
    for title, lines in sheets.items():
        sheet = book.create_sheet(title)
        for line in lines:
            sheet.append(line)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def ta_thermal():
    """Two segments of a DMA, with the line that ends the first."""
    names = (
        "Time (min)",
        "Temperature (°C)",
        "Storage Modulus (MPa)",
        "Loss Modulus (MPa)",
        "Frequency (Hz)",
    )
    lines = [
        "CLOSED",
        "",
        "Version\t1.0",
        "Instrument\tDMA Q800 V21.3",
        "Size\t12.5\t3.2\t17.5",
        "Nsig\t5",
    ]
    lines += [f"Sig{i}\t{name}" for i, name in enumerate(names, 1)] + [
        "OrgFile\tC:\\TA\\nbr.001",
        "StartOfData",
    ]
    points = zip(OMEGA / (2 * np.pi), STIFFNESS, strict=True)
    rows = [f"{i}\t30.5\t{k.real:.10g}\t{k.imag:.10g}\t{f:.10g}" for i, (f, k) in enumerate(points)]
    return "\r\n".join([*lines, *rows[:2], "-1\t2", *rows[2:], ""]).encode("utf-16")
