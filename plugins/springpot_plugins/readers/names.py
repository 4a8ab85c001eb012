"""What a column is called.

Names and symbols in the languages that instruments speak, as the role they stand for.

Names are compared folded: without accents, case, spaces, hyphens, dots and underscores, with primes
as ``'``.
"""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

from .languages import LANGUAGES
from .title_words import says_whole_swing, without_swing

EXACT = {
    "T": "temperature",
    "t": "time",
    "f": "frequency",
    "w": "omega",
    "W": "omega",
    "d": "phase",
}
"""Single letters, where case decides."""

_WORDS = {
    "omega": """
        omega ω angularfrequency angfrequency angularfreq angfreq radianfrequency circularfrequency
        oscillationangularfrequency ang.frequency pulsation frequenceangulaire kreisfrequenz
        winkelfrequenz frecuenciaangular frequenzaangolare pulsazione frequenciaangular
    """,
    "frequency": """
        frequency freq testfrequency oscillationfrequency excitationfrequency ν frequence frequenz
        messfrequenz frecuencia frequenza frequencia
    """,
    "storage": """
        storage storagemodulus m' g' gp gprime storageshearmodulus shearstoragemodulus
        elasticshearmodulus shearmodulus(elasticcomponent) elasticmodulusg' elasticmodulus
        storagestiffness k' kp e' ep eprime estor estorage gstor gstorage storageyoungsmodulus reg*
        re(g*) tensilestoragemodulus storageyoung'smodulus storagetensilemodulus kprime storagemodul
        stormod effectivestiffness keff geff eeff equivalentstiffness keq effektivesteifigkeit
        rigiditeeffective c' re(f/x) ref/x dynamicstiffnessreal realstiffness realpartofstiffness
        horizontalstiffness kh kdyn' k'dyn cdyn' c'dyn kdynstorage storagekdyn shearstiffness
        rigidezefectiva rigidezzaefficace aquivalentesteifigkeit rigiditeequivalente
        raideurequivalente rigidezequivalente storagemod re(k) re(k*) rek* re(g) re(e) re(e*)
        kstorage kstor storagek moduledestockage moduledeconservation moduleelastique modulestockage
        moduleconservation moduledecisaillementdestockage moduledestockageencisaillement
        speichermodul speicherschubmodul schubspeichermodul speichersteifigkeit
        modulodealmacenamiento moduloelastico modulodealmacenaje almacenamiento
        modulodiconservazione moduloconservativo modulodiimmagazzinamento modulodiaccumulo
        modulodistoccaggio modulodearmazenamento
    """,
    "loss": """
        loss lossmodulus m'' g'' gpp gdoubleprime gdprime lossshearmodulus shearlossmodulus
        viscousmodulus viscousshearmodulus shearmodulus(viscouscomponent) lossstiffness k'' kpp e''
        epp edoubleprime eloss gloss lossyoungsmodulus img* im(g*) kdoubleprime tensilelossmodulus
        lossyoung'smodulus losstensilemodulus edprime lossmodul viscousmodulusg'' c'' im(f/x) imf/x
        dynamicstiffnessimag imaginarystiffness imaginarypartofstiffness kdyn'' k''dyn cdyn'' c''dyn
        kdynloss losskdyn lossmod im(k) im(k*) imk* im(g) im(e) im(e*) kloss lossk moduledeperte
        moduledepertes moduleperte moduledissipatif modulevisqueux moduledeperteencisaillement
        verlustmodul verlustschubmodul schubverlustmodul verluststeifigkeit modulodeperdida
        modulodeperdidas moduloviscoso perdida modulodiperdita modulodissipativo modulodeperda
    """,
    "magnitude": """
        dynamischesteifigkeit dynsteifigkeit kdyn dynstiffness dynamicspringrate rigiditedynamique
        raideurdynamique rigidezdinamica rigidezzadinamica c* |c*| |c| |f/x| f/x magnitude
        complexmodulus |m*| |g*| g* gstar complexshearmodulus |e*| e* estar
        shearmodulus(complexcomponent) |k| |k*| k* |g| |e| dynamicmodulus dynamicstiffness absg*
        abse* complexstiffness |complexmodulus| modulecomplexe komplexermodul komplexerschubmodul
        betragkomplexermodul modulocomplejo modulocomplesso modulocomplexo
    """,
    "phase": """
        phaseangle phase delta δ phaseshift lossangle phi φ phaselag phaseshiftangle angledephase
        dephasage angledeperte phasenwinkel verlustwinkel phasenverschiebung
        phasenverschiebungswinkel angulodefase angulodeperdida desfase angolodifase angolodiperdita
        sfasamento ϕ
    """,
    "loss_factor": """
        lossfactor tandelta tanδ tan(delta) tan(δ) tand tgδ tgdelta losstangent dampingfactor
        dissipationfactor eta tanphi tanφ facteurdeperte facteurdamortissement tangentedelta
        verlustfaktor verlustf dampfungsfaktor factordeperdida factordeamortiguamiento
        factordeamortiguacion tangentedeperdida fattorediperdita fattoredismorzamento
        factordeperdidas fatordeperda
    """,
    "viscosity": """
        complexviscosity |η*| η* eta* |eta*| etastar shearviscosity(complexcomponent)
        viscositecomplexe komplexeviskositat betrag(viskositat) viscosidadcompleja
        viscositacomplessa |viscosity| viscosidadecomplexa
    """,
    "dynamic_viscosity": """
        η' eta' etaprime dynamicviscosity dynamischeviskositat
    """,
    "out_of_phase_viscosity": """
        η'' eta'' etadoubleprime outofphaseviscosity outofphasecomplexviscosity
    """,
    "storage_compliance": """
        j' jprime storagecompliance d' speichernachgiebigkeit re(x/f) rex/f receptancereal
        realreceptance re(receptance)
    """,
    "complex_compliance": """
        j* d* complexcompliance x/f receptance komplexenachgiebigkeit
    """,
    "loss_compliance": """
        j'' jdoubleprime losscompliance d'' verlustnachgiebigkeit
    """,
    "receptance_imaginary": """
        im(x/f) imx/f receptanceimag imaginaryreceptance im(receptance)
    """,
    "period": """
        period periode période periodo periodendauer schwingungsdauer perioddauer 周期
    """,
    "damping": """
        dampingcoefficient dampingconstant viscousdamping equivalentdamping equivalentviscousdamping
        ceq cdyn dampfungskoeffizient dampfungskonstante coefficientdamortissement
        coeficientedeamortiguamiento coefficientedismorzamento
    """,
    "damping_ratio": """
        dampingratio equivalentdampingratio equivalentviscousdampingratio effectivedampingratio heq
        ξ ζ βeff betaeff βeq betaeq xi zeta ξeq ξeff zetaeq xieq xieff zetaeff heff
        effectivedamping dampfungsgrad
        dampfungsmass lehrschesdampfungsmass aquivalentedampfung tauxdamortissement
        razondeamortiguamiento aquivalentesdampfungsmass aquivalenterdampfungsgrad
        effektivesdampfungsmass effektivedampfung tauxdamortissementequivalent
        amortissementequivalent rapportdamortissement amortiguamientoequivalente
        amortiguamientoefectivo rapportodismorzamento smorzamentoequivalente
    """,
    "force_amplitude": """
        forceamplitude forceamp loadamplitude loadamp dynamicforce dynforce fdyn dynamicload
        peakforce maxforce maximumforce peakload maxload maximumload f0 torqueamplitude torqueamp
        dynamictorque peaktorque momentenamplitude drehmomentamplitude drehmomentenamplitude
        amplitudeducouple amplituddelpar ampiezzadicoppia
        kraftamplitude dynamischekraft dynkraft maximalkraft maxkraft amplitudedeforce
        forcedynamique effortdynamique forcemax fuerzamaxima fuerzadinamica forzamassima
        荷重振幅 最大荷重 動荷重 力幅值 最大力 最大阻尼力 하중진폭 최대하중 амплитудасилы
    """,
    "energy": """
        energydissipatedpercycle dissipatedenergypercycle energypercycle dissipatedenergy edc
        energydissipated energydissipation hysteresisenergy energyloss losswork looparea
        verlustarbeit dampfungsarbeit dissipierteenergie hystereseflache energiedissipee
        energiedissipeeparcycle energiadisipada energiadissipata 吸収エネルギー 消費エネルギー
        履歴面積 耗能 耗散能量 滞回面积 소산에너지 рассеяннаяэнергия
    """,
    "storage_sd": """
        storagesd storagestd storagestdunc storagestandarduncertainty storageuncertainty
        storageerror g'sd g'std gpsd gpstd storagestandarddeviation sdstorage
    """,
    "loss_sd": """
        losssd lossstd lossstdunc lossstandarduncertainty lossuncertainty losserror g''sd g''std
        gppsd gppstd lossstandarddeviation sdloss
    """,
    "temperature": """
        temperature temp ts sampletemperature temperatur probentemperatur temperatura teta ϑ
        sampletemp specimentemperature specimentemp tempsample tempspecimen temperaturesample
        temperaturespecimen materialtemperature materialtemp probentemp temperaturprobe tempprobe
        temperaturderprobe temperatureechantillon temperatureeprouvette temperaturedeleprouvette
        temperaturamuestra temperaturademuestra temperaturadelamuestra temperaturaprobeta
        temperaturacampione temperaturadelcampione temperaturaprovino temperaturadelprovino
        chambertemperature chambertemp tempchamber tempkammer kammertemperatur temperatureenceinte
        umgebungstemperatur ambienttemperature temperaturedelechantillon testtemperature
        temperaturedegc
    """,
    "amplitude": """
        oscillationstrain strainamplitude shearstrainamplitude complexshearstrain shearstrainamp
        strainamp amplitude amp peakamplitude amplitudepeak x0 dynamicamplitude dynamicdisplacement
        displacementamplitude dispamplitude dispamp displacementamp 両振幅 全振幅 dynamicstrain
        straindyn dynstrain shearstrain strain γ0 gamma0 γ ɣ gamma %strain strainγ ga
        amplitudededeformation ddyn xdyn
        deformationdecisaillement deformation scherdeformation deformationsamplitude dehnung
        dehnungsamplitude wegamplitude amplituddedeformacion deformaciondecizalla
        deformacionporcizalla deformacion amplitud ampiezza deformazioneditaglio deformazione
        ampiezzadideformazione deformacaodecisalhamento dynamplitude ε ε0 εdyn εa γdyn γa epsdyn
        epsilondyn xamp zeropeakamplitude dyndehnung dehnungdyn dynamischedehnung dynweg
        dynamischerweg dynamischeamplitude dynamicdisp dynamicdispl dyndisp dyndispl
        dynamicdeflection doubleamplitude peaktopeakamplitude peaktopeakdisplacement doppelamplitude
        amplitudecreteacrete deplacementdynamique deformationdynamique amplitudedynamique
        deformaciondinamica angleamplitude angleamp angularamplitude twistamplitude dynamicangle
        rotationamplitude winkelamplitude drehwinkelamplitude verdrehwinkelamplitude
        amplitudeangulaire amplitudangular ampiezzaangolare
    """,
    "repeat": """
        repeat rep replicate repetition replica wiederholung repeticion ripetizione
    """,
    "time": """
        time elapsedtime timeelapsed totaltime testtime experimenttime curetime curingtime
        ageingtime agingtime gelationtime waitingtime steptime runtime time(action) temps
        tempsecoule zeit gesamtzeit messzeit versuchszeit verstrichenezeit laufzeit tiempo
        tiempotranscurrido tempo tempotrascorso tempodecorrido abschnittszeit
    """,
    "gap": """
        gap entrefer spalt messspalt entrehierro fessura traferro spaltweite
    """,
    "normal_force": """
        normalforce axialforce forcenormale normalkraft fuerzanormal forzanormale fn
    """,
    "torque": """
        oscillationtorque torque couple drehmoment moment par momentotorsor coppia
    """,
    "displacement": """
        oscillationdisplacement angulardisplacement deflectionangle auslenkwinkel
    """,
    "raw_phase": """
        rawphase rawphase(torque) rawphaseangle rohphase
    """,
    "coherence": """
        coherence coh γ² γ^2 gamma² gamma^2 magnitudesquaredcoherence msc ordinarycoherence koharenz
        coherencia coerenza coherencefunction
    """,
    "status": """
        status statut estado stato messstatus zustand pointstatus
    """,
    "stress": """
        oscillationstress complexshearstress shearstress contraintedecisaillement schubspannung
        tensioncortante esfuerzocortante sforzoditaglio
    """,
    "shift": """
        logat at log10at shiftfactor shiftfactors logshiftfactor logalphat
    """,
    "relaxation": """
        relaxation erelax grelax relaxationmodulus relaxationstiffness relaxationfunction
        shearrelaxationmodulus stressrelaxationmodulus tensilerelaxationmodulus
        relaxationsmodul modulederelaxation g(t) e(t) k(t) gt
    """,
    "compliance": """
        compliance creepcompliance creep creepfunction recoverablecompliance
        creeprecoverycompliance j(t) d(t) kriechnachgiebigkeit nachgiebigkeit complaisance
        complaisancedefluage
    """,
    "relaxation_time": """
        relaxationtime relaxationtimes relaxtime retardationtime retardationtimes taui lambdai
        relaxationszeit relaxationszeiten retardationszeit tempsderelaxation tiempoderelajacion
    """,
    "flow": """
        shearrate viscosity scherrate viskositat gradientdecisaillement viscosite
    """,
}
"""Names of each role, parted by blanks; the first is the one that is offered."""
NAMES: dict[str, tuple[str, ...]] = {
    role: (*words.split(), *LANGUAGES.get(role, ())) for role, words in _WORDS.items()
}
FREQUENCIES = frozenset({"omega", "frequency"})
MODULI = frozenset(
    {
        "storage",
        "loss",
        "magnitude",
        "viscosity",
        "dynamic_viscosity",
        "storage_compliance",
        "damping",
    }
)
ROLES = frozenset(NAMES) - {"shift", "relaxation", "compliance", "relaxation_time", "flow"}
"""What a user may say that a column is."""

_PRIMES = str.maketrans(
    {"′": "'", "’": "'", "‘": "'", "´": "'", "`": "'", "″": "''", "”": "''", "“": "''", '"': "''"}
    # The same of Windows, where it was read as latin-1.
    | {"\x91": "'", "\x92": "'", "\x93": "''", "\x94": "''"}
)
_LATEX = re.compile(r"\\(?:text|mathrm|mathit|rm|left|right)\b|[${}^\\]")
_SAMPLE = re.compile(
    r"T[\s_.]*(?:sample|specimen|probe|material|muestra|campione|provino)\Z", re.IGNORECASE
)
"""A sample's temperature by its symbol; written small it may be a time."""
_MOVED = frozenset(
    ("displacement", "disp", "displ", "deflection", "weg", "verschiebung", "deplacement")
)
"""What is an amplitude where it counts from trough to crest, and may be a mean position otherwise.
"""
_SINCE = re.compile(
    r"(?:time|zeit|temps|tiempo|tempo)[\s_]+(?:from|since|after|seit|ab|nach|depuis|desde|da)[\s_]"
    r"(?:.*[\s_])?[^\W\d_]{4,}\Z",
    re.IGNORECASE,
)
"""A time that says from when it counts, as in ``time since loading``.

A shorter last word may be a unit.
"""
_LOST = re.compile(r"[\s_.\-:,]+")


@lru_cache(maxsize=4096)
def fold(name: str) -> str:
    """A name without accents, case, spaces and signs between words."""
    plain = unicodedata.normalize("NFKD", name[:200].translate(_PRIMES).replace("∗", "*"))
    kept = "".join(sign for sign in plain if not unicodedata.combining(sign))
    return _LOST.sub("", kept.casefold().replace("ß", "ss").replace("µ", "μ"))


_ROLE_OF = {fold(name): role for role, names in reversed(NAMES.items()) for name in names}
_RANK = {fold(name): i for names in NAMES.values() for i, name in enumerate(names)}
_MEANS = ("mean", "avg")
AVERAGED = MODULI | {"phase", "loss_factor", "damping_ratio", "relaxation", "compliance"}
"""What may be the mean of several measurements: ``G'_mean``."""
_QUALIFIED = re.compile(
    r"(?<!\w)(?:actual|measured|ist|istwert|gemessen|mesur[ée]e?|r[ée]elle?|medid[ao]|misurat[ao]|実測|实测|실측)(?!\w)",
    re.IGNORECASE,
)
"""What says that a value was measured, beside one that was set."""
_NEUTRAL = frozenset(
    fold(word)
    for word in (
        *(
            "stiffness",
            "modulus",
            "dynamic stiffness",
            "dynamic modulus",
            "dyn stiffness",
            "dyn modulus",
            "complex stiffness",
            "complex modulus",
            "dynamische steifigkeit",
            "dyn steifigkeit",
            "steifigkeit",
            "modul",
            "raideur",
            "rigidité",
        ),
        *(
            "module",
            "rigidez",
            "módulo",
            "rigidezza",
            "modulo",
            "剛性",
            "弾性率",
            "刚度",
            "模量",
            "модуль",
            "жесткость",
        ),
    )
)
"""Words before a symbol that leave it to the symbol which part of a modulus is meant."""


def names_a_modulus(name: str) -> bool:
    """Whether a name says modulus or stiffness and no more.

    So that its numbers tell which part it is.
    """
    return fold(name) in _NEUTRAL


@lru_cache(maxsize=4096)
def role_of(name: str) -> str | None:
    """What a column of that name is, or None."""
    name = name.strip()
    if "\\" in name or "$" in name:
        name = _LATEX.sub("", name[:200].replace("\\prime", "'").replace("\\ast", "*")).strip()
    # Before accents and case are taken away, which tell some symbols apart.
    if name in EXACT:
        return EXACT[name]
    folded = fold(name)
    # The whole name before its parts: "loss factor" is no loss with a remark.
    if folded in _ROLE_OF:
        return _ROLE_OF[folded]
    if _is_of_sample(name):
        return "temperature"
    if _SINCE.match(name):
        return "time"
    if folded.endswith("ampl"):
        return _ROLE_OF.get(f"{folded}itude")
    if (bare := without_swing(name)) != name:
        return _swinging(bare, says_whole_swing(name))
    # Means of repeated measurements stand for the quantity itself.
    if folded.endswith(_MEANS):
        stem = _ROLE_OF.get(folded.removesuffix("mean").removesuffix("avg"))
        if stem not in AVERAGED:
            # A mean force is one over a cycle, not over repeated measurements.
            return None
        return stem
    # "Frequency (actual)" beside "Frequency (set)": the measured one counts.
    if _QUALIFIED.search(name):
        return _ROLE_OF.get(fold(_QUALIFIED.sub(" ", name)))
    # "Storage modulus G'" says it twice, "Frequency (f)" explains its symbol.
    if " " in name and len(name) < 100:
        words, _, last = name.rpartition(" ")
        symbol = last.strip("(),")
        # "Relaxation modulus G(t)" has brackets of its own.
        symbol += ")" * symbol.count("(")
        if fold(words) in _NEUTRAL:
            # "Stiffness K'": the symbol says which.
            return _ROLE_OF.get(fold(symbol))
        first = _ROLE_OF.get(fold(words))
        if first is not None and first == (EXACT.get(symbol) or _ROLE_OF.get(fold(symbol))):
            return first
    return None


def _swinging(bare: str, is_whole: bool) -> str | None:
    """The role of a name whose words for where an amplitude counts from were taken away."""
    role = role_of(bare)
    if role in ("amplitude", "force_amplitude"):
        return role
    if is_whole and fold(bare) in _MOVED:
        return "amplitude"
    # A peak that is no amplitude, such as a phase from peak to peak, is something else.
    return None


def rank(name: str) -> int:
    """How surely a column of that name is the one meant; lower is surer."""
    if name in EXACT or _is_of_sample(name):
        return 0
    # "Temperature (sample)" is the sample's as "sample temperature" is.
    return _RANK.get(fold(name), _RANK.get(fold(name.replace("(", "").replace(")", "")), 99))


def _is_of_sample(name: str) -> bool:
    """Whether a name is the symbol of a sample's temperature, as in ``T_sample``."""
    return name.startswith("T") and bool(_SAMPLE.match(name))
