-- What the code of schema 4 wrote: a baseline, a whole flight, one owed, and flights of a run that cut each at its first kill.
BEGIN TRANSACTION;
CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
INSERT INTO "meta" VALUES('system','Linux');
CREATE TABLE origins (id INTEGER PRIMARY KEY, parts TEXT NOT NULL UNIQUE);
INSERT INTO "origins" VALUES(1,'{"sim": "sim", "requirements": "requirements", "code": "code", "mutant": "", "situation": "situation", "realised": "realised", "cutting": ""}');
INSERT INTO "origins" VALUES(2,'{"sim": "sim", "requirements": "requirements", "code": "code", "mutant": "mutant", "situation": "situation", "realised": "", "cutting": ""}');
INSERT INTO "origins" VALUES(3,'{"sim": "sim", "requirements": "requirements", "code": "code", "mutant": "mutant", "situation": "situation", "realised": "", "cutting": "cutting"}');
CREATE TABLE outcomes (
    id INTEGER PRIMARY KEY,
    key TEXT NOT NULL UNIQUE,
    origin INTEGER REFERENCES origins (id),
    track INTEGER REFERENCES tracks (id),
    mutant TEXT NOT NULL, guideword TEXT NOT NULL, parameter TEXT NOT NULL, magnitude TEXT NOT NULL, situation TEXT NOT NULL, seed INTEGER NOT NULL, ending TEXT NOT NULL, invalid TEXT NOT NULL, truncated TEXT NOT NULL, carried INTEGER NOT NULL, altered INTEGER NOT NULL, infected_at_s REAL, struck TEXT NOT NULL, duration_s REAL, digest TEXT NOT NULL, perceived_digest TEXT NOT NULL, stack_error TEXT NOT NULL, readings TEXT NOT NULL, violations TEXT NOT NULL, realised TEXT NOT NULL
);
INSERT INTO "outcomes" VALUES(1,'5677e25ed72da9cd2e79529ea255f2e8691c0b86ab356aa96ca28775e3e727d1',1,1,'baseline','','','','T0O0W0D0H1',0,'landed','','',100,0,NULL,'',60.0,'clean','','','["SR1", "safety", 0.3, null, 1, false]
["SR2", "safety", 0.3, null, 1, false]
["SR2-literal", "reported", 0.3, null, 1, false]
["OP1", "operability", 0.3, null, 1, false]','','["T", true]
["O", true]
["W", true]
["D", true]
["H", true]');
INSERT INTO "outcomes" VALUES(2,'07d366e2e323e149399cf5fcbdd2c9abd50387d7b8dfc0c112b62cdfc268c56d',2,2,'LATE-human@3s','LATE','human','3s','T0O0W0D0H1',0,'landed','','',100,5,3.0,'',60.0,'LATE-human@3s','','','["SR1", "safety", 0.3, null, 1, false]
["SR2", "safety", -0.1, 20.0, 1, false]
["SR2-literal", "reported", 0.3, null, 1, false]
["OP1", "operability", 0.3, null, 1, false]','["SR2", "safety", 20.0, 1.0, 2.0, 1.65, ""]','');
INSERT INTO "outcomes" VALUES(3,'fdacc86cdb1b28cce08ca402bf949771d541e942e825e46c27abbff0f21655db',3,3,'LATE-human@3s','LATE','human','3s','T0O0W0D0H1',0,'cut','','first kill',100,5,3.0,'',25.0,'cut','','','["SR1", "safety", 0.3, null, 1, false]
["SR2", "safety", -0.1, 20.0, 1, false]
["SR2-literal", "reported", 0.3, null, 1, false]
["OP1", "operability", 0.3, null, 1, false]','["SR2", "safety", 20.0, 1.0, 2.0, 1.65, ""]','');
INSERT INTO "outcomes" VALUES(4,'18303f3607b48bada32ae6211c2f8d27e6cc5778758e0267d31fc8b7f195e249',3,2,'LATE-human@3s','LATE','human','3s','T0O0W0D0H1',1,'landed','','first kill',100,5,3.0,'',60.0,'LATE-human@3s','','','["SR1", "safety", 0.3, null, 1, false]
["SR2", "safety", 0.3, null, 1, false]
["SR2-literal", "reported", 0.3, null, 1, false]
["OP1", "operability", 0.3, null, 1, false]','','');
INSERT INTO "outcomes" VALUES(5,'5e9b583e2705d991089996e43683e6f9bb50e6c3ba6f7b5dc05f91117771bf1d',NULL,NULL,'LATE-human@3s','LATE','human','3s','T0O0W0D0H1',3,'landed','','first kill',100,5,3.0,'',60.0,'cut','','','["SR1", "safety", 0.3, null, 1, false]
["SR2", "safety", 0.3, null, 1, false]
["SR2-literal", "reported", 0.3, null, 1, false]
["OP1", "operability", 0.3, null, 1, false]','','');
CREATE TABLE plan (
    key TEXT PRIMARY KEY,
    mutant TEXT NOT NULL,
    situation TEXT NOT NULL,
    seed INTEGER NOT NULL,
    canary INTEGER NOT NULL
, origin INTEGER REFERENCES origins (id)) WITHOUT ROWID;
INSERT INTO "plan" VALUES('07d366e2e323e149399cf5fcbdd2c9abd50387d7b8dfc0c112b62cdfc268c56d','LATE-human@3s','T0O0W0D0H1',0,0,2);
INSERT INTO "plan" VALUES('18303f3607b48bada32ae6211c2f8d27e6cc5778758e0267d31fc8b7f195e249','LATE-human@3s','T0O0W0D0H1',1,0,3);
INSERT INTO "plan" VALUES('5677e25ed72da9cd2e79529ea255f2e8691c0b86ab356aa96ca28775e3e727d1','baseline','T0O0W0D0H1',0,0,1);
INSERT INTO "plan" VALUES('bb8ce5e8a079651bf0e10d34bc23f8b95fe80fe66185312d358e03e770d8f6bb','LATE-human@3s','T0O0W0D0H1',2,0,3);
INSERT INTO "plan" VALUES('be85a0a472917190104cb07e944b15debf5fa00b9f604bb8dff9c49fca8a0985','LATE-human@3s','T0O0W0D0H1',1,0,2);
INSERT INTO "plan" VALUES('fdacc86cdb1b28cce08ca402bf949771d541e942e825e46c27abbff0f21655db','LATE-human@3s','T0O0W0D0H1',0,0,3);
CREATE TABLE tracks (id INTEGER PRIMARY KEY, sha256 BLOB NOT NULL UNIQUE, track BLOB NOT NULL);
INSERT INTO "tracks" VALUES(1,X'3B066804F6D1D077173CFE4D06002E6A61E6F21C2B2E648417962115F1AFCD8E',X'636C65616E');
INSERT INTO "tracks" VALUES(2,X'5D5766CF2D78701614200418EE1450690D9AF12C84D52545E4802F001AD53099',X'77686F6C65');
INSERT INTO "tracks" VALUES(3,X'378BFCE5CDA2599A6CDA399F1CACEF861E4E575EC794744DCF0E55E9C4780633',X'637574');
CREATE INDEX outcomes_by_flight ON outcomes (mutant, situation, seed, truncated, key, origin);
CREATE INDEX invalid_outcomes ON outcomes (key) WHERE invalid != ''
;
COMMIT;
PRAGMA user_version=4;
