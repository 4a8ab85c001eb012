"""What columns are called in languages beside English, French, German, Spanish, Italian and Portuguese.

Written as people write them; compared folded as in `names`.
"""

from __future__ import annotations

LANGUAGES: dict[str, tuple[str, ...]] = {
    "omega": (
        *("角频率", "角頻率", "角周波数", "각주파수", "угловая частота", "круговая частота"),
        *("częstotliwość kątowa", "częstość kołowa", "pulsacja", "hoekfrequentie", "cirkelfrequentie"),
        *("úhlová frekvence", "kruhová frekvence", "vinkelfrekvens", "açısal frekans"),
    ),
    "frequency": (
        *("振動数", "加振振動数", "加振周波数", "测试频率"),
        *("频率", "頻率", "周波数", "주파수", "частота", "częstotliwość", "frequentie", "frekvence", "frekvens"),
        "frekans",
    ),
    "storage": (
        *("储能模量", "储存模量", "儲存模量", "弹性模量", "貯蔵弾性率", "貯蔵せん断弾性率", "貯蔵剛性率"),
        *("저장 탄성률", "저장 탄성계수", "저장 모듈러스", "модуль накопления", "модуль упругости"),
        *("moduł zachowawczy", "moduł sprężystości", "moduł magazynowania", "opslagmodulus"),
        *("elastický modul", "paměťový modul", "lagringsmodul", "depolama modülü"),
        *("等価剛性", "等価水平剛性", "等效刚度", "等效剛度", "水平等效刚度", "등가강성", "эквивалентная жесткость"),
    ),
    "loss": (
        *("损耗模量", "损失模量", "損失模量", "粘性模量", "損失弾性率", "損失せん断弾性率", "損失剛性率"),
        *("손실 탄성률", "손실 탄성계수", "손실 모듈러스", "модуль потерь", "модуль вязкости"),
        *("moduł stratności", "moduł strat", "verliesmodulus"),
        *("ztrátový modul", "viskózní modul", "förlustmodul", "kayıp modülü"),
    ),
    "magnitude": (
        *("复数模量", "复模量", "复合模量", "複素弾性率", "복소 탄성률", "комплексный модуль", "moduł zespolony"),
        *("complexe modulus", "komplexní modul", "komplex modul", "kompleks modül"),
        *("動的ばね定数", "動ばね定数", "動剛性", "动刚度", "動剛度", "동강성", "동적강성", "динамическая жесткость"),
    ),
    "phase": (
        *("相位角", "相角", "位相角", "位相差", "위상각", "фазовый угол", "угол сдвига фаз", "угол потерь"),
        *("kąt fazowy", "przesunięcie fazowe", "kąt przesunięcia fazowego", "fasehoek", "fázový úhel"),
        *("fázový posun", "fasvinkel", "faz açısı", "损耗角", "滞后角", "損失角"),
    ),
    "loss_factor": (
        *("损耗因子", "损耗角正切", "損失正接", "損失係数", "손실 계수", "손실 탄젠트", "тангенс потерь"),
        *("тангенс угла потерь", "коэффициент потерь", "współczynnik strat", "tangens kąta strat"),
        *("verliesfactor", "dempingsfactor", "ztrátový činitel", "förlustfaktor", "kayıp faktörü"),
    ),
    "viscosity": (
        *("复数粘度", "复数黏度", "複素粘度", "複素粘性率", "복소 점도", "комплексная вязкость"),
        *("lepkość zespolona", "complexe viscositeit", "komplexní viskozita", "komplex viskositet"),
    ),
    "damping": ("減衰係数", "等価減衰係数", "等価粘性減衰係数", "阻尼系数", "阻尼係數", "等效阻尼系数", "감쇠계수"),
    "damping_ratio": (
        *("減衰比", "等価減衰定数", "等価減衰比", "等価粘性減衰定数", "阻尼比", "等效阻尼比", "등가감쇠비", "감쇠비"),
        *("коэффициент эквивалентного демпфирования", "относительное демпфирование"),
    ),
    "temperature": ("温度", "溫度", "온도", "температура", "temperatuur", "teplota", "sıcaklık"),
    "amplitude": (
        *("剪切应变", "剪應變", "应变", "应变振幅", "せん断ひずみ", "せん断歪み", "ひずみ", "歪み"),
        *("전단 변형률", "변형률", "деформация сдвига", "сдвиговая деформация", "деформация", "амплитуда"),
        *("odkształcenie ścinające", "odkształcenie", "amplituda", "afschuifvervorming", "schuifrek", "vervorming"),
        *("smyková deformace", "deformace", "skjuvtöjning", "töjning", "kayma gerinimi", "gerinim"),
        *(
            "変位振幅",
            "動的変位",
            "動ひずみ",
            "せん断ひずみ振幅",
            "振幅",
            "位移幅值",
            "位移振幅",
            "动态应变",
            "변위진폭",
        ),
    ),
    "time": ("时间", "時間", "시간", "время", "czas", "tijd", "čas", "tid", "zaman"),
    "gap": ("间隙", "ギャップ", "зазор", "szczelina", "spleet"),
    "torque": ("扭矩", "トルク", "토크", "крутящий момент", "moment obrotowy", "koppel", "krouticí moment", "tork"),
    "stress": (
        *("剪切应力", "せん断応力", "전단 응력", "напряжение сдвига", "naprężenie ścinające", "schuifspanning"),
        *("smykové napětí", "skjuvspänning", "kayma gerilmesi"),
    ),
    "flow": (
        *("剪切速率", "粘度", "せん断速度", "전단 속도", "점도", "скорость сдвига", "вязкость", "lepkość"),
        *("szybkość ścinania", "afschuifsnelheid", "viscositeit"),
    ),
}

CHANNELS: dict[str, tuple[str, ...]] = {
    "time": (*LANGUAGES["time"], "時刻", "経過時間", "经过时间"),
    "displacement": (
        *("変位", "变位", "位移", "行程", "角度", "ひずみ", "应变", "變形", "变形", "변위", "변형률"),
        *("перемещение", "смещение", "деформация", "przemieszczenie", "verplaatsing", "posunutí", "förskjutning"),
        *("yer değiştirme", "deplasman"),
    ),
    "force": (
        *("荷重", "力", "试验力", "載荷", "载荷", "負荷", "应力", "応力", "扭矩", "トルク", "하중", "힘", "응력"),
        *("усилие", "сила", "нагрузка", "напряжение", "siła", "kracht", "síla", "kraft", "kuvvet", "yük"),
    ),
}
"""The channels of time signals."""
